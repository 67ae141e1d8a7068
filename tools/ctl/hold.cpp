// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/held.hpp"

#include <memory>

namespace afterglow {
namespace {

struct Hold : Held {
    std::string mode;
};

Result<int> hold(const Settings &settings, const Hold &wanted) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<UniqueFd> wish =
        daemon->open("HoldMode", "ss", wanted.mode.c_str(), wanted.reason.c_str());
    if (!wish)
        return wish.error();
    return keep(*wish, {{"mode", wanted.mode}, {"reason", wanted.reason}}, wanted, settings);
}

} // namespace

Action declare_hold(CLI::App &app, const Settings &settings) {
    const auto wanted = std::make_shared<Hold>();
    app.add_option("MODE", wanted->mode, "auto, always-on, interval or off")
        ->type_name("")
        ->required();
    declare_held(app, *wanted);
    return [&settings, wanted] { return hold(settings, *wanted); };
}

} // namespace afterglow
