// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/command.hpp"
#include "tools/command_line/run_program.hpp"

#include <algorithm>
#include <utility>
#include <vector>

using namespace afterglow;

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
    return run_program(app, argc, argv, [&] {
        const auto chosen = std::ranges::find_if(
            commands, [](const auto &command) { return command.first->parsed(); });
        return chosen->second();
    });
}
