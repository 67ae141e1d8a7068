// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"
#include "tools/command_line/run_program.hpp"
#include "tools/ctl/command.hpp"

namespace {

void declare_settings(CLI::App &app, afterglow::Settings &settings) {
    auto *bus = app.add_option_group("bus", "where the daemon is; the system bus if not given");
    bus->add_flag_callback(
        "--system", [&] { settings.bus = "system"; }, "the system bus");
    bus->add_flag_callback(
        "--session", [&] { settings.bus = "session"; }, "the session bus");
    bus->add_option("--bus", settings.bus, "the bus at an address")
        ->type_name("ADDRESS")
        ->check([](const std::string &bus) {
            return afterglow::names_bus(bus)
                       ? std::string()
                       : bus + " is no address of a bus, as unix:path=/run/bus";
        });
    bus->require_option(0, 1);
    app.add_flag("--json", settings.json, "print one JSON document (monitor: one for each frame)");
}

} // namespace

int main(int argc, char **argv) {
    afterglow::Settings settings;
    CLI::App app("Looks at a running afterglowd, and tells it what to do.", "afterglowctl");
    app.set_version_flag("--version", AFTERGLOW_VERSION);
    app.fallthrough();
    declare_settings(app, settings);
    const afterglow::Action action =
        afterglow::declare_commands(app, afterglow::all_commands(), settings);
    app.footer("Exit status: 0 done; 1 the daemon or the system refused; 2 wrong usage. request "
               "and hold give\nthat of their command.");
    return afterglow::run_program(app, argc, argv, action);
}
