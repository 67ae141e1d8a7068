// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/ipc/command.hpp"

#include "core/base/child_process.hpp"
#include "core/base/temporary_directory.hpp"
#include "core/base/write_file.hpp"
#include "tools/bench/ipc/results.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <poll.h>
#include <unistd.h>

namespace afterglow::bench {
namespace {

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
Result<std::vector<Measured>> measure(const IpcArguments &arguments) {
    std::vector<Measured> cases;
    for (const int readers : arguments.readers)
        for (const Transport *transport :
             {&afterglow_transport, &shmsink_transport, &pipewire_transport})
            cases.push_back({transport->name, readers, {}});
    for (int round = 0; round < arguments.rounds; ++round) {
        std::size_t next = 0;
        for (const int readers : arguments.readers) {
            for (const Transport *transport :
                 {&afterglow_transport, &shmsink_transport, &pipewire_transport}) {
                fmt::print(stderr, "round {} of {}: {}, {} readers\n", round + 1, arguments.rounds,
                           transport->name, readers);
                const Result<TemporaryDirectory> own =
                    TemporaryDirectory::create("afterglow-bench-");
                if (!own)
                    return own.error();
                Result<CaseResult> result =
                    run_case(*transport, readers, arguments.frames / arguments.rounds, own->path());
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

} // namespace

void IpcArguments::add_to(CLI::App &command) {
    command.add_option("--json", json_file, "Write the numbers to FILE")->type_name("FILE");
    command
        .add_option("--frames", frames,
                    "Frames for each transport and number of readers, over all rounds")
        ->check(CLI::Range(1, 6000))
        ->capture_default_str();
    command
        .add_option("--rounds", rounds, "In each, all transports are measured one after another")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    command.add_option("--readers", readers, "Numbers of readers to measure with")
        ->check(CLI::Range(1, static_cast<int>(Session::most_readers)))
        ->capture_default_str();
}

Status bench_ipc(const IpcArguments &arguments) {
    if (arguments.frames < arguments.rounds)
        return Error{"--frames: there must be one for each round, at least", EINVAL};
    const Result<TemporaryDirectory> folder = TemporaryDirectory::create("afterglow-bench-");
    if (!folder)
        return folder.error();
    const Result<ChildProcess> pipewire = start_pipewire(folder->path());
    if (!pipewire)
        return pipewire.error();
    const Result<std::vector<Measured>> cases = measure(arguments);
    if (!cases)
        return cases.error();
    fmt::print("{}", table(*cases));
    return arguments.json_file.empty() ? ok() : write_file(arguments.json_file, json(*cases));
}

} // namespace afterglow::bench
