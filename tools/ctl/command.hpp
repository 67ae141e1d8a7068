// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <functional>
#include <span>
#include <string>

namespace afterglow {

/// What a person says once for all commands.
struct Settings {
    std::string bus = "system"; ///< "system", "session" or a D-Bus address
    bool json = false;          ///< JSON on stdout instead of text
};

/// Does what a command is there for, writing to stdout. Gives the program's exit status. Errors: no
/// bus, no daemon on it, or something was refused; the message is for the person who asked.
using Action = std::function<Result<int>()>;

/// A command of afterglowctl.
struct Command {
    const char *name;
    const char *help;
    /// Declares its options and gives what it does; `settings` are read when it does it.
    Action (*declare)(CLI::App &app, const Settings &settings);
};

/// All of them, in the order of --help.
std::span<const Command> all_commands();

/// Makes them subcommands of `app`, one of which is required. Gives what that one does.
Action declare_commands(CLI::App &app, std::span<const Command> commands, const Settings &settings);

// Each in a file of its name.
Action declare_status(CLI::App &app, const Settings &settings);
Action declare_monitor(CLI::App &app, const Settings &settings);
Action declare_stats(CLI::App &app, const Settings &settings);
Action declare_latency(CLI::App &app, const Settings &settings);
Action declare_snapshot(CLI::App &app, const Settings &settings);
Action declare_mode(CLI::App &app, const Settings &settings);
Action declare_policy(CLI::App &app, const Settings &settings);
Action declare_request(CLI::App &app, const Settings &settings);
Action declare_hold(CLI::App &app, const Settings &settings);
Action declare_requests(CLI::App &app, const Settings &settings);
Action declare_measure(CLI::App &app, const Settings &settings);
Action declare_reload(CLI::App &app, const Settings &settings);
Action declare_log_level(CLI::App &app, const Settings &settings);
Action declare_devices(CLI::App &app, const Settings &settings);
Action declare_probe(CLI::App &app, const Settings &settings);
Action declare_calibration(CLI::App &app, const Settings &settings); // in its folder
Action declare_characterise(CLI::App &app, const Settings &settings);
Action declare_calibrate(CLI::App &app, const Settings &settings);

} // namespace afterglow
