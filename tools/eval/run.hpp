// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "core/result.hpp"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// How depth is to be made, as told on a command line.
struct TuningArguments {
    std::string preset = "default";
    std::vector<std::string> assignments; ///< key=value

    void add_to(CLI::App &command);
    /// The preset with the assignments made, or what is wrong with them.
    Result<std::pair<EstimatorOptions, GatePolicy>> resolve() const;
};

/// afterglow-eval run: scores one recording, or the synthetic room.
struct RunArguments {
    std::string dataset;
    TuningArguments tuning;
    int frames = 0;
    int wake_latency = 0;
    int workers = 2;
    std::uint64_t seed = 1;
    double motion = 1;
    bool noise = true;
    bool json = false;
    std::string csv;
    std::string dump;

    void add_to(CLI::App &command);
};

Status run(const RunArguments &arguments);

} // namespace afterglow
