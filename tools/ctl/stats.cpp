// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/properties.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

Result<int> show(const Settings &settings, bool reset) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> properties = daemon->properties();
    if (!properties)
        return properties.error();
    if (reset)
        if (const Result<Json> done = daemon->call("ResetStatistics", ""); !done)
            return done.error();
    if (settings.json)
        return print_json(scalars(*properties));
    for (const auto &[name, value] : properties->items())
        if (value.is_primitive() && name != "Calibration") // a file: `calibration show`
            fmt::print("{:<20} {}\n", name, with_unit(value, unit(name)));
    return 0;
}

} // namespace

Action declare_stats(CLI::App &app, const Settings &settings) {
    const auto reset = std::make_shared<bool>(false);
    app.add_flag("--reset", *reset, "then start all counts anew");
    return [&settings, reset] { return show(settings, *reset); };
}

} // namespace afterglow
