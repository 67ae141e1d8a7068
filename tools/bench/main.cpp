// SPDX-License-Identifier: Apache-2.0
//
// afterglow-bench ipc: from the publication of a frame to its readers, in other processes, by
// afterglow's ring and by other transports.
#include "core/base/child_process.hpp"
#include "core/base/temporary_directory.hpp"
#include "tools/bench/results.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <poll.h>
#include <unistd.h>

using namespace afterglow;
using namespace afterglow::bench;

namespace {

struct Options {
    std::string json_file;
    int frames = 1200;
    int rounds = 5;
    std::vector<int> readers = {1, 2, 4, 8};
};

/// A PipeWire daemon of our own, without a session manager.
Result<ChildProcess> start_pipewire(const std::string &folder) {
    setenv("PIPEWIRE_RUNTIME_DIR", folder.c_str(), 1); // for the readers as well
    auto daemon =
        ChildProcess::start({.command = {"pipewire"}, .environment = {"PIPEWIRE_DEBUG=0"}});
    if (!daemon)
        return daemon;
    const std::string socket = folder + "/pipewire-0";
    for (int tries = 0; access(socket.c_str(), F_OK) != 0; ++tries) {
        if (tries == 1000 || !daemon->running())
            return Error{"the PipeWire daemon does not start", EIO};
        poll(nullptr, 0, 10);
    }
    return daemon;
}

/// All transports in each round, so that what else the machine does hits all alike.
Result<std::vector<Measured>> measure(const Options &options) {
    std::vector<Measured> cases;
    for (const int readers : options.readers)
        for (const Transport *transport :
             {&afterglow_transport, &shmsink_transport, &pipewire_transport})
            cases.push_back({transport->name, readers, {}});
    for (int round = 0; round < options.rounds; ++round) {
        std::size_t next = 0;
        for (const int readers : options.readers) {
            for (const Transport *transport :
                 {&afterglow_transport, &shmsink_transport, &pipewire_transport}) {
                fmt::print(stderr, "round {} of {}: {}, {} readers\n", round + 1, options.rounds,
                           transport->name, readers);
                const Result<TemporaryDirectory> own =
                    TemporaryDirectory::create("afterglow-bench-");
                if (!own)
                    return own.error();
                Result<CaseResult> result =
                    run_case(*transport, readers, options.frames / options.rounds, own->path());
                if (!result)
                    return result.error();
                CaseResult &sum = cases[next++].result;
                sum.latencies_ns.insert(sum.latencies_ns.end(), result->latencies_ns.begin(),
                                        result->latencies_ns.end());
                sum.missed += result->missed;
            }
        }
    }
    return cases;
}

int ipc(const Options &options) {
    const Result<TemporaryDirectory> folder = TemporaryDirectory::create("afterglow-bench-");
    const Result<ChildProcess> pipewire =
        folder ? start_pipewire(folder->path()) : Result<ChildProcess>(folder.error());
    const Result<std::vector<Measured>> cases =
        pipewire ? measure(options) : Result<std::vector<Measured>>(pipewire.error());
    if (!cases) {
        fmt::print(stderr, "afterglow-bench: {}\n", cases.error().message);
        return EXIT_FAILURE;
    }
    fmt::print("{}", table(*cases));
    if (!options.json_file.empty() && !(std::ofstream(options.json_file) << json(*cases)).flush()) {
        fmt::print(stderr, "afterglow-bench: {} cannot be written\n", options.json_file);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Measures afterglow beside others.", "afterglow-bench");
    app.require_subcommand(1);
    Options options;
    CLI::App *command = app.add_subcommand(
        "ipc", "The time from publishing a frame (VGA depth and confidence, 60 a second) to the\n"
               "moment a reader in another process can read it");
    command->add_option("--json", options.json_file, "Write the numbers to FILE")
        ->type_name("FILE");
    command
        ->add_option("--frames", options.frames,
                     "Frames for each transport and number of readers, over all rounds")
        ->check(CLI::Range(1, 6000))
        ->capture_default_str();
    command
        ->add_option("--rounds", options.rounds,
                     "In each, all transports are measured one after another")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    command->add_option("--readers", options.readers, "Numbers of readers to measure with")
        ->check(CLI::Range(1, static_cast<int>(Session::most_readers)))
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    return ipc(options);
}
