// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace afterglow::bench {

/// afterglow-bench frame: CPU time of one thread for a frame, and for its parts, beside what a user
/// would take instead, by Google Benchmark.
struct FrameArguments {
    std::vector<std::string> datasets;
    std::string json_file;
    std::string filter = ".*";
    int frames = 20;
    int repetitions = 5;

    void add_to(CLI::App &command);
};

Status bench_frames(const FrameArguments &arguments);

} // namespace afterglow::bench
