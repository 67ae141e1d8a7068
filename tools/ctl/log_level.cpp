// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/properties.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

namespace afterglow {
namespace {

Result<int> show_or_set(const Settings &settings, const std::optional<std::string> &level) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    if (level)
        if (const Status set = daemon->set(log_interface, "LogLevel", "s", level->c_str()); !set)
            return set.error();
    if (level && !settings.json)
        return 0;
    const Result<Json> now = daemon->get(log_interface, "LogLevel");
    if (!now)
        return now.error();
    if (settings.json)
        return print_json({{"log_level", *now}});
    fmt::print("{}\n", with_unit(*now, ""));
    return 0;
}

} // namespace

Action declare_log_level(CLI::App &app, const Settings &settings) {
    const auto level = std::make_shared<std::optional<std::string>>();
    app.add_option("LEVEL", *level,
                   "emerg, alert, crit, err, warning, notice, info or debug: log what is as urgent "
                   "or more; shown if not given")
        ->type_name("");
    return [&settings, level] { return show_or_set(settings, *level); };
}

} // namespace afterglow
