// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/command_line/unknown_command.hpp"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>

namespace afterglow {

inline constexpr int exit_failure = 1;
inline constexpr int exit_usage = 2;

/// What a main() returns: parses the command line and calls `action`, which gives the exit status.
/// What fails is said on stderr after the program's name: 1. A wrong command line is 2;
/// `explain_unknown` finds words for a command that does not exist. Standard output that cannot be
/// written is a failure, too.
int run_program(CLI::App &app, int argc, const char *const *argv,
                const std::function<Result<int>()> &action,
                const std::function<std::string(const CLI::App &app, const std::string &name)>
                    &explain_unknown = no_such_command);

/// Refuses all but numbers from `least` to `most`; CLI::Range takes NaN.
CLI::Validator number_between(double least, double most);

} // namespace afterglow
