// SPDX-License-Identifier: Apache-2.0
#include "core/base/standard_output.hpp"
#include "tools/calibrate/command.hpp"
#include "tools/command_line/unknown_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

using namespace afterglow;

namespace {

constexpr int exit_failure = 1;
constexpr int exit_usage = 2;

int fail(const std::string &sentence, int code = exit_failure) {
    std::fflush(stdout); // what was found so far stands before why it ends
    fmt::print(stderr, "afterglow-calibrate: {}\n", sentence);
    return code;
}

} // namespace

/// 0: done; 1: it could not be done; 2: the command line is wrong.
int main(int argc, char **argv) {
    CLI::App app{"Measures the calibration of a rig with a board.", "afterglow-calibrate"};
    app.require_subcommand(1);
    app.set_version_flag("--version", AFTERGLOW_VERSION);
    std::vector<std::pair<const CLI::App *, CalibrateAction>> commands;
    const auto add = [&](const char *name, const char *help,
                         CalibrateAction (*declare)(CLI::App &)) {
        CLI::App &command = *app.add_subcommand(name, help);
        commands.emplace_back(&command, declare(command));
    };
    add("print-board", "Write a board to print, at true scale", declare_print_board);
    add("capture", "Record a board before the cameras of a configuration, guided", declare_capture);
    add("solve", "Calibrate a rig from what was recorded", declare_solve);
    try {
        app.parse(argc, argv);
        for (const auto &[command, action] : commands) {
            if (!command->parsed())
                continue;
            const Result<int> done = action();
            if (!done)
                return fail(done.error().message);
            const Status written = flush_standard_output();
            return written ? *done : fail(written.error().message);
        }
        return exit_usage;
    } catch (const CLI::ParseError &error) {
        if (const auto name = unknown_command(app))
            return fail(no_such_command(innermost(app), *name), exit_usage);
        return app.exit(error) == 0 ? 0 : exit_usage;
    } catch (const std::exception &error) { // OpenCV's
        return fail(error.what());
    }
}
