// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/properties.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

Result<int> reload(const Settings &settings) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> restart_needed = daemon->call("Reload", "");
    if (!restart_needed)
        return restart_needed.error();
    if (settings.json)
        return print_json({{"restart_needed", *restart_needed}});
    if (!restart_needed->empty())
        fmt::print("changed, but read only at the start of afterglowd:\n");
    for (const Json &key : *restart_needed)
        fmt::print("  {}\n", with_unit(key, ""));
    return 0;
}

} // namespace

Action declare_reload(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return reload(settings); };
}

} // namespace afterglow
