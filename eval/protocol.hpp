// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/run.hpp"
#include "eval/scoring/evaluation.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// afterglow-eval protocol: the table by which constants are judged. Each recording is scored
/// forwards, backwards, with every second frame, and with shifted starts, and the synthetic room
/// with several seeds; each beside the same frames with the pose from the true depth
/// (oracle_preset).
struct ProtocolArguments {
    std::vector<std::string> datasets;
    TuningArguments tuning;
    std::vector<int> shifts{1, 2, 3, 5}; ///< frames left out at the start
    int frames = 0;
    int wake_latency = 0;
    bool oracle = true;
    int workers = 2;

    void add_to(CLI::App &command);
};

Status protocol(const ProtocolArguments &arguments);

} // namespace afterglow
