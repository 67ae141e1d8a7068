// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace afterglow {

std::span<const Command> all_commands() {
    static constexpr Command commands[] = {
        {"status", "what the daemon does now", declare_status},
        {"monitor", "a line of 40 columns for each frame", declare_monitor},
        {"stats", "everything the daemon counts", declare_stats},
        {"latency", "how old frames are when they arrive here", declare_latency},
        {"snapshot", "the newest image and its depth, as a file", declare_snapshot},
        {"mode", "show or set when the TOF camera is lit", declare_mode},
        {"policy", "show, set or save what decides about the light", declare_policy},
        {"request", "ask for accurate or fresh depth for some time", declare_request},
        {"hold", "keep a mode for some time", declare_hold},
        {"requests", "what is asked for or held now, and by whom", declare_requests},
        {"measure", "measure one frame as soon as possible", declare_measure},
        {"reload", "read the daemon's configuration again", declare_reload},
        {"log-level", "show or set what the daemon logs", declare_log_level},
        {"devices", "cameras and lights that are there, and what each can do", declare_devices},
        {"probe", "a first configuration for them", declare_probe},
        {"calibration", "show, check or convert the calibration of two cameras",
         declare_calibration},
        {"characterise", "measure the noise of the TOF camera", declare_characterise},
        {"calibrate", "measure it with a board: print-board, capture, solve", declare_calibrate},
    };
    return commands;
}

Action declare_commands(CLI::App &app, std::span<const Command> commands,
                        const Settings &settings) {
    app.require_subcommand(1);
    std::vector<std::pair<const CLI::App *, Action>> actions;
    for (const Command &command : commands) {
        CLI::App &declared = *app.add_subcommand(command.name, command.help);
        actions.emplace_back(&declared, command.declare(declared, settings));
    }
    return [actions] {
        return std::find_if(actions.begin(), actions.end(),
                            [](const auto &each) { return each.first->parsed(); })
            ->second();
    };
}

} // namespace afterglow
