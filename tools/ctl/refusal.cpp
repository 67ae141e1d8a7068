// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/refusal.hpp"

#include "core/base/printable.hpp"
#include "ipc/bus/errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <sstream>

namespace afterglow {
namespace {

/// What to say for an error. "{why}" is the daemon's own sentence, "{bus}" the name of the bus.
struct Sentence {
    const char *error;
    const char *text;
};

constexpr const char *no_daemon =
    "no afterglowd runs on {bus}; `systemctl start afterglowd` starts "
    "the system's";
constexpr const char *too_old = "afterglowd on {bus} does not know this ({why}); it is of another "
                                "version than afterglowctl " AFTERGLOW_VERSION;
constexpr const char *no_answer =
    "afterglowd on {bus} does not answer; `systemctl status afterglowd` "
    "says whether it hangs";

constexpr Sentence sentences[] = {
    {SD_BUS_ERROR_SERVICE_UNKNOWN, no_daemon},
    {SD_BUS_ERROR_NAME_HAS_NO_OWNER, no_daemon},
    {SD_BUS_ERROR_ACCESS_DENIED,
     "not allowed: {why} Root may, and who is in the group: `sudo adduser USER GROUP`, then log in "
     "again"},
    {SD_BUS_ERROR_LIMITS_EXCEEDED,
     "{why} End one that is no longer needed; `afterglowctl requests` and `afterglowctl status` "
     "show what is open"},
    {SD_BUS_ERROR_INVALID_ARGS, "{why}"},
    {SD_BUS_ERROR_UNKNOWN_METHOD, too_old},
    {SD_BUS_ERROR_UNKNOWN_OBJECT, too_old},
    {SD_BUS_ERROR_UNKNOWN_INTERFACE, too_old},
    {SD_BUS_ERROR_UNKNOWN_PROPERTY, too_old},
    {SD_BUS_ERROR_NO_REPLY, no_answer},
    {SD_BUS_ERROR_TIMEOUT, no_answer},
    {SD_BUS_ERROR_DISCONNECTED, "the connection to {bus} was lost; try again when it is back"},
    {error_out_of_range, "{why} `afterglowctl policy get` shows the ranges"},
    {error_not_running,
     "{why} The cameras run while somebody reads, as `afterglowctl monitor` does; `afterglowctl "
     "status` says whether one is lost"},
    {error_budget_spent,
     "{why} Wait until it has grown back, or raise it: `afterglowctl policy set DutyCycleBudget "
     "PERCENT`"},
    {error_dark,
     "{why} `afterglowctl requests` shows who holds the mode off; `afterglowctl mode auto` ends it "
     "where nobody does"},
    {error_timed_out, "{why} `afterglowctl status` says whether the TOF camera is lost"},
    {error_no_policy_file, "{why} Start afterglowd with --policy FILE, as its systemd unit does"},
    {error_bad_configuration,
     "the configuration is wrong, and nothing was changed. Correct it and reload again:\n{why}"},
    {error_busy, "{why} Wait for the answers to what was asked before"},
};

/// As printable(), a line at a time, without the bounds of one line: and a full stop at the end.
std::string daemons_sentence(const sd_bus_error &error, int code) {
    std::istringstream lines(error.message != nullptr ? error.message : std::strerror(-code));
    std::string sentence;
    for (std::string line; std::getline(lines, line);)
        sentence += (sentence.empty() ? "" : "\n") + printable(line);
    if (!sentence.empty() && std::strchr(".!?", sentence.back()) == nullptr)
        sentence += '.';
    return sentence;
}

} // namespace

std::string describe_bus(const std::string &bus) {
    if (bus == "system" || bus == "session")
        return fmt::format("the {} bus", bus);
    return fmt::format("the bus at {}", printable(bus));
}

Error refusal(const std::string &bus, const sd_bus_error &error, int code) {
    const auto known =
        std::find_if(std::begin(sentences), std::end(sentences), [&](const Sentence &sentence) {
            return sd_bus_error_has_name(&error, sentence.error) != 0;
        });
    const char *text =
        known != std::end(sentences) ? known->text : "afterglowd on {bus} did not do it: {why}";
    return Error{fmt::format(fmt::runtime(text), fmt::arg("bus", describe_bus(bus)),
                             fmt::arg("why", daemons_sentence(error, code))),
                 -code};
}

} // namespace afterglow
