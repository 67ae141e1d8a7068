// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace afterglow {

/// The subcommand that the command line has named last; `app` itself where it has named none.
const CLI::App &innermost(const CLI::App &app);

/// The first word of a command line that CLI11 has refused because it names none of the subcommands
/// of innermost(app); nothing where it was refused for something else.
std::optional<std::string> unknown_command(const CLI::App &app);

/// `app` has none of that name: `there is no command "statsu", did you mean "stats"?`
std::string no_such_command(const CLI::App &app, const std::string &name);

} // namespace afterglow
