// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/live.hpp"
#include "tools/eval/run.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>

using namespace afterglow;

/// 0: done; 1: it could not be done; 2: the command line is wrong.
int main(int argc, char **argv) {
    CLI::App app{"Scores afterglow's depth against the truth.", "afterglow-eval"};
    app.require_subcommand(1);
    app.set_version_flag("--version", AFTERGLOW_VERSION);

    RunArguments run_arguments;
    CLI::App *run_command =
        app.add_subcommand("run", "Score a recording as fast as it can be read");
    run_arguments.add_to(*run_command);
    LiveArguments live_arguments;
    CLI::App *live_command = app.add_subcommand(
        "live", "Start the daemon, read its frames in real time as any program would, score them");
    live_arguments.add_to(*live_command);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const Status done = *run_command ? run(run_arguments) : live(live_arguments);
    if (!done) {
        fmt::print(stderr, "afterglow-eval: {}\n", done.error().message);
        return done.error().code == EINVAL ? 2 : 1;
    }
    return 0;
}
