// SPDX-License-Identifier: Apache-2.0
#include "config/parameter_table.hpp"
#include "core/base/log.hpp"
#include "core/base/standard_output.hpp"
#include "daemon/daemon.hpp"
#include "daemon/open_rig.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <sstream>
#include <string>
#include <unistd.h>

namespace {

// Exit codes. The unit does not restart the daemon after the last two: a person has to act first.
constexpr int exit_clean = 0;
constexpr int exit_failure = 1; ///< a device, the bus or the system refused
constexpr int exit_usage = 2;
constexpr int exit_configuration = 78; ///< EX_CONFIG of sysexits.h

struct Arguments {
    afterglow::ConfigurationFiles files{AFTERGLOW_CONFIG_FILE, {}, {}};
    bool has_config = false;
    bool check = false;
    bool print_config = false;
    bool print_reference = false;
    bool darken = false;
};

/// Every line of an error is one line of the log.
int fail(const afterglow::Error &error, int code) {
    std::istringstream lines(error.message);
    for (std::string line; std::getline(lines, line);)
        afterglow::log(afterglow::Priority::error, line);
    return code;
}

int print(const std::string &text) {
    std::fputs(text.c_str(), stdout);
    const afterglow::Status written = afterglow::flush_standard_output();
    return written ? exit_clean : fail(written.error(), exit_failure);
}

int run(const Arguments &arguments) {
    if (arguments.print_reference)
        return print(afterglow::reference_page());
    const afterglow::Result<afterglow::Config> config =
        arguments.print_config && !arguments.has_config
            ? afterglow::Config{}
            : afterglow::read_configuration(arguments.files);
    if (!config)
        return fail(config.error(), exit_configuration);
    if (arguments.check)
        return print(fmt::format("{}: good\n", arguments.files.config));
    if (arguments.darken) {
        const afterglow::Status dark = afterglow::darken(*config);
        return dark ? exit_clean : fail(dark.error(), exit_failure);
    }
    if (arguments.print_config)
        return print(afterglow::to_toml(*config));
    const afterglow::Status served = afterglow::serve(*config, arguments.files);
    return served ? exit_clean : fail(served.error(), exit_failure);
}

/// Puts /dev/null where standard input, output or error is closed: otherwise the next file that is
/// opened, such as the light's, would get its number and with it the lines of the log.
void keep_standard_streams() {
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(fd, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) != fd)
            std::_Exit(exit_failure); // `fd` is the lowest free number: there is no /dev/null
}

} // namespace

int main(int argc, char **argv) {
    keep_standard_streams();
    std::signal(SIGPIPE, SIG_IGN); // a reader of our log that leaves must not end us
    std::signal(SIGHUP, SIG_IGN);  // nor a reload before there is something to reload
    Arguments arguments;
    CLI::App app("Gives depth for every camera frame, with the TOF illuminator dark most of the "
                 "time.",
                 "afterglowd");
    app.set_version_flag("--version", AFTERGLOW_VERSION);
    auto *config = app.add_option("--config", arguments.files.config,
                                  "configuration file; the files FILE.d/*.toml override it")
                       ->type_name("FILE")
                       ->capture_default_str();
    auto *bus = app.add_option_group("bus", "where to be found; overrides the configuration");
    bus->add_flag_callback(
        "--system", [&] { arguments.files.bus = "system"; }, "the system bus");
    bus->add_flag_callback(
        "--session", [&] { arguments.files.bus = "session"; }, "the session bus");
    bus->add_option("--bus", arguments.files.bus, "the bus at an address")
        ->type_name("ADDRESS")
        ->check([](const std::string &bus) {
            return afterglow::names_bus(bus)
                       ? std::string()
                       : bus + " is no address of a bus, as unix:path=/run/bus";
        });
    bus->require_option(0, 1);
    app.add_option("--policy", arguments.files.policy,
                   "what SavePolicy on D-Bus writes, and what overrides the configuration")
        ->type_name("FILE");
    auto *check = app.add_flag("--check", arguments.check,
                               "only check the configuration, and say what is wrong with it");
    auto *darken = app.add_flag("--darken", arguments.darken,
                                "only switch the illuminator off, as after a crash of the daemon")
                       ->excludes(check);
    app.add_flag("--print-config", arguments.print_config,
                 "only print the configuration with every key explained: that of --config, or "
                 "else the defaults")
        ->excludes(check)
        ->excludes(darken);
    app.add_flag("--print-reference", arguments.print_reference, "print docs/configuration.md")
        ->group("");
    app.footer("Exit status: 0 stopped as asked, or the recording is over; 1 a device, the bus or "
               "the system\nrefused; 2 wrong usage; 78 wrong configuration.");
    try {
        app.parse(argc, argv);
        arguments.has_config = config->count() > 0;
        return run(arguments);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? exit_clean : exit_usage;
    } catch (const std::exception &error) {
        return fail({error.what()}, exit_failure);
    }
}
