// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/rights.hpp"

#include <cerrno>

namespace afterglow {
namespace {

/// The reason in an answer that is a refusal in any case.
std::optional<std::string> denial(const Result<UniqueFd> &answer) {
    if (answer || answer.error().code != EACCES)
        return std::nullopt;
    return answer.error().message;
}

} // namespace

Rights rights_of_caller(Daemon &daemon) {
    constexpr const char *no_option = "";
    constexpr const char *no_mode = "";
    return {
        denial(daemon.open("OpenStream", "a{sv}", 1, no_option, "b", 0)),
        denial(daemon.open("OpenStream", "a{sv}", 2, "images", "b", 1, no_option, "b", 0)),
        denial(daemon.open("HoldMode", "ss", no_mode, "")),
    };
}

} // namespace afterglow
