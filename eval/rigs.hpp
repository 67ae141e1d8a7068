// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/run.hpp"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// afterglow-eval rigs: two different cameras in the synthetic room, of many sizes and at several
/// distances, with the view of each or of another camera published; beside them the rig with
/// registered depth on the same motion.
struct RigsArguments {
    std::vector<std::string> only; ///< words of sweep_words(); empty: all rigs
    TuningArguments tuning;
    int frames = 90; ///< of each rig; all 81 then take 20 minutes on two cores
    std::uint64_t seed = 1;
    double motion = 1;
    int workers = 2;
    std::string json; ///< a file; empty: none

    void add_to(CLI::App &command);
};

Status rigs(const RigsArguments &arguments);

} // namespace afterglow
