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

Result<int> show_or_set(const Settings &settings, const std::optional<std::string> &mode) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    if (mode)
        if (const Status set = daemon->set(depth_interface, "Mode", "s", mode->c_str()); !set)
            return set.error();
    if (mode && !settings.json)
        return 0;
    const Result<Json> properties = daemon->properties();
    if (!properties)
        return properties.error();
    if (settings.json)
        return print_json({{"mode", text(*properties, "Mode")},
                           {"effective_mode", text(*properties, "EffectiveMode")}});
    fmt::print("{}\n", text(*properties, "Mode"));
    return 0;
}

} // namespace

Action declare_mode(CLI::App &app, const Settings &settings) {
    const auto mode = std::make_shared<std::optional<std::string>>();
    app.add_option("NAME", *mode, "auto, always-on, interval or off; shown if not given")
        ->type_name("");
    return [&settings, mode] { return show_or_set(settings, *mode); };
}

} // namespace afterglow
