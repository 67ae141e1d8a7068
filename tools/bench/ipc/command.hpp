// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace afterglow::bench {

/// afterglow-bench ipc: from the publication of a frame to its readers, in other processes, by
/// afterglow's ring and by other transports.
struct IpcArguments {
    std::string json_file;
    int frames = 1200;
    int rounds = 5;
    std::vector<int> readers = {1, 2, 4, 8};

    void add_to(CLI::App &command);
};

Status bench_ipc(const IpcArguments &arguments);

} // namespace afterglow::bench
