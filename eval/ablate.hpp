// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/run.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// The preset with one of its stages switched off.
struct Variant {
    std::string_view name;
    std::vector<std::string> assignments; ///< key=value
    std::string_view shows; ///< what the estimator does without it (docs/estimation.md)
};

/// The first has all stages; the others are compared with it.
const std::vector<Variant> &ablation_variants();

/// afterglow-eval ablate: scores the preset with each of its stages switched off in turn.
struct AblateArguments {
    std::vector<std::string> datasets;
    TuningArguments tuning; ///< of every variant, before its own assignments
    FootageArguments footage;
    int workers = 2;
    bool json = false;
    bool markdown = false;

    void add_to(CLI::App &command);
};

Status ablate(const AblateArguments &arguments);

} // namespace afterglow
