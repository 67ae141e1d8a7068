// SPDX-License-Identifier: Apache-2.0
#include "core/base/standard_output.hpp"
#include "tools/command_line/unknown_command.hpp"
#include "tools/ctl/commands.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <string>

namespace {

constexpr int exit_failure = 1;
constexpr int exit_usage = 2;

int fail(const std::string &sentence, int code = exit_failure) {
    fmt::print(stderr, "afterglowctl: {}\n", sentence);
    return code;
}

} // namespace

int main(int argc, char **argv) {
    using afterglow::Status;
    std::string bus = "system";
    std::string path;
    std::string mode;
    int frames = 0;
    bool json = false;
    std::function<Status()> command;

    CLI::App app("Looks at a running afterglowd, and tells it what to do.", "afterglowctl");
    app.set_version_flag("--version", AFTERGLOW_VERSION);
    app.require_subcommand(1);
    app.fallthrough();
    auto *where = app.add_option_group("bus", "where the daemon is; the system bus if not given");
    where->add_flag_callback(
        "--system", [&] { bus = "system"; }, "the system bus");
    where->add_flag_callback(
        "--session", [&] { bus = "session"; }, "the session bus");
    where->add_option("--bus", bus, "the bus at an address")->type_name("ADDRESS");
    where->require_option(0, 1);

    app.add_subcommand("status", "what the daemon does now")->callback([&] {
        command = [&] { return afterglow::show_status(bus); };
    });
    auto *stats = app.add_subcommand("stats", "everything the daemon counts");
    stats->add_flag("--json", json, "as one JSON object");
    stats->callback([&] { command = [&] { return afterglow::show_statistics(bus, json); }; });
    auto *monitor = app.add_subcommand("monitor", "a line of 40 columns for each frame");
    monitor->add_option("--frames", frames, "stop after so many; 0 = never")
        ->check(CLI::NonNegativeNumber);
    monitor->callback([&] { command = [&] { return afterglow::monitor(bus, frames); }; });
    auto *snapshot = app.add_subcommand("snapshot", "the newest image and its depth, as a file");
    snapshot
        ->add_option("file", path,
                     "NAME.png: image and depth in colours; NAME.pgm: depth in millimetres, 16 "
                     "bits; -: the PNG to stdout")
        ->type_name("FILE")
        ->required();
    snapshot->callback([&] { command = [&] { return afterglow::snapshot(bus, path); }; });
    auto *set = app.add_subcommand("mode", "show or set when the TOF camera is lit");
    set->add_option("name", mode, "auto, always-on, interval or off")->type_name("NAME");
    set->callback([&] { command = [&] { return afterglow::change_mode(bus, mode); }; });
    app.add_subcommand("devices", "cameras and lights that are there, and what each can do")
        ->callback([&] { command = [] { return afterglow::show_devices(); }; });
    auto *probe = app.add_subcommand("probe", "a first configuration for them");
    probe->add_option("file", path, "where to write it; stdout if not given")->type_name("FILE");
    probe->callback([&] { command = [&] { return afterglow::probe(path); }; });
    app.footer("Exit status: 0 done; 1 the daemon or the system refused; 2 wrong usage.");

    try {
        app.parse(argc, argv);
        Status done = command();
        if (done)
            done = afterglow::flush_standard_output();
        return done ? 0 : fail(done.error().message);
    } catch (const CLI::ParseError &error) {
        if (const auto name = afterglow::unknown_command(app))
            return fail(afterglow::no_such_command(app, *name), exit_usage);
        return app.exit(error) == 0 ? 0 : exit_usage;
    } catch (const std::exception &error) {
        return fail(error.what());
    }
}
