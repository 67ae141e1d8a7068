// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/run.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace afterglow {

/// afterglow-eval live: the main job end to end. The daemon runs in a process of its own, in real
/// time; this one reads its frames as any program would, and scores them.
struct LiveArguments {
    std::string replay; ///< folder in TUM layout; empty: the synthetic room
    TuningArguments tuning;
    int frames = 0;
    std::string picture = "afterglow.png";

    void add_to(CLI::App &command);
};

Status live(const LiveArguments &arguments);

} // namespace afterglow
