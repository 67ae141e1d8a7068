// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/frame/command.hpp"

#include "tools/bench/frame/benchmarks.hpp"

#include <fmt/format.h>

#include <benchmark/benchmark.h>
#include <cerrno>

namespace afterglow::bench {

void FrameArguments::add_to(CLI::App &command) {
    command
        .add_option("dataset", datasets,
                    "Folders in a known layout (docs/datasets.md), or synthetic rooms")
        ->required();
    command.add_option("--json", json_file, "Write Google Benchmark's JSON to FILE")
        ->type_name("FILE");
    command.add_option("--filter", filter, "Only benchmarks whose names this expression finds")
        ->capture_default_str();
    command.add_option("--frames", frames, "Of each dataset only the first so many")
        ->check(CLI::Range(2, 100000))
        ->capture_default_str();
    command
        .add_option("--repetitions", repetitions,
                    "Of each benchmark, taking turns with those of the others")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
}

Status bench_frames(const FrameArguments &arguments) {
    const auto tour = plan_tour(arguments.datasets, arguments.frames);
    if (!tour)
        return tour.error();
    register_pipelines(*tour);
    register_kernels(*tour);
    register_opencv(*tour);

    // Repetitions take turns in random order, so that what else the machine does hits all alike.
    // An iteration of a benchmark is at least the whole tour: that is enough time for each.
    std::vector<std::string> words = {
        "afterglow-bench",
        "--benchmark_enable_random_interleaving=true",
        "--benchmark_min_time=0.01",
        "--benchmark_time_unit=us",
        fmt::format("--benchmark_repetitions={}", arguments.repetitions),
        "--benchmark_filter=" + arguments.filter};
    if (!arguments.json_file.empty()) {
        words.push_back("--benchmark_out=" + arguments.json_file);
        words.push_back("--benchmark_out_format=json");
    }
    std::vector<char *> argv;
    for (std::string &word : words)
        argv.push_back(word.data());
    int argc = static_cast<int>(argv.size());
    benchmark::Initialize(&argc, argv.data());
    if (argc > 1)
        return Error{std::string("Google Benchmark does not know ") + argv[1], EINVAL};
    if (benchmark::RunSpecifiedBenchmarks() == 0)
        return Error{"no benchmark is called like " + arguments.filter, EINVAL};
    return ok();
}

} // namespace afterglow::bench
