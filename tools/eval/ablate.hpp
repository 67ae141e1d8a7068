// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.hpp"
#include "tools/eval/run.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace afterglow {

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
