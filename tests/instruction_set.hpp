// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/catch.hpp"

#include <cstdint>
#include <hwy/targets.h>

namespace afterglow::testing {

/// While it lives kernels are those of one of Highway's targets, and not of the best.
class InstructionSet {
public:
    explicit InstructionSet(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    ~InstructionSet() {
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().DeInit();
    }
    InstructionSet(const InstructionSet &) = delete;
    InstructionSet &operator=(const InstructionSet &) = delete;
};

} // namespace afterglow::testing

/// In a test case that calls kernels: it runs with each instruction set of this processor.
#define AFTERGLOW_ON_EACH_INSTRUCTION_SET()                                                        \
    const std::int64_t target = GENERATE(from_range(hwy::SupportedAndGeneratedTargets()));         \
    CAPTURE(hwy::TargetName(target));                                                              \
    const afterglow::testing::InstructionSet instruction_set(target)
