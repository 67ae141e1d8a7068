// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/run_program.hpp"

#include "core/base/standard_output.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

namespace afterglow {

int run_program(CLI::App &app, int argc, const char *const *argv,
                const std::function<Result<int>()> &action,
                const std::function<std::string(const CLI::App &app, const std::string &name)>
                    &explain_unknown) {
    const auto fail = [&](const std::string &sentence, int code) {
        std::fflush(stdout); // what was found so far stands before why it ends
        fmt::print(stderr, "{}: {}\n", app.get_name(), sentence);
        return code;
    };
    try {
        app.parse(argc, argv);
        const Result<int> done = action();
        if (!done)
            return fail(done.error().message, exit_failure);
        const Status written = flush_standard_output();
        return written ? *done : fail(written.error().message, exit_failure);
    } catch (const CLI::ParseError &error) {
        if (const auto name = unknown_command(app))
            return fail(explain_unknown(innermost(app), *name), exit_usage);
        if (app.exit(error) != 0)
            return exit_usage;
        const Status written = flush_standard_output(); // --help and --version
        return written ? 0 : fail(written.error().message, exit_failure);
    } catch (const std::exception &error) {
        return fail(error.what(), exit_failure);
    }
}

CLI::Validator number_between(double least, double most) {
    const std::string range = fmt::format("{:g} to {:g}", least, most);
    return {[least, most, range](std::string &text) {
                double value = 0;
                const bool within =
                    CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
                return within ? std::string() : text + " is no number from " + range;
            },
            range, ""};
}

} // namespace afterglow
