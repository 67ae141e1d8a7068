// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/json.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// What all wishes have that end with their descriptor.
struct Held {
    std::string reason;
    std::vector<std::string> command; ///< empty: held until a signal comes
};
void declare_held(CLI::App &app, Held &held);

/// Says that the daemon has granted the wish `granted`, and keeps its descriptor `wish` open as
/// long as the command runs: gives the command's exit status, 128 and the signal's number when one
/// killed it. Without a command, until SIGINT, SIGTERM or SIGHUP: gives 0. Signals that only this
/// process gets are handed on to the command. Errors: the command cannot be started; without one,
/// the daemon has ended the request.
Result<int> keep(const UniqueFd &wish, const Json &granted, const Held &held,
                 const Settings &settings);

} // namespace afterglow
