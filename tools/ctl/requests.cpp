// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/requests.hpp"

#include "tools/ctl/command.hpp"
#include "tools/ctl/properties.hpp"

#include <fmt/format.h>

#include <pwd.h>

namespace afterglow {
namespace {

std::string user_name(double user) {
    const passwd *entry = ::getpwuid(static_cast<uid_t>(user));
    return entry != nullptr ? entry->pw_name : fmt::format("user {:.0f}", user);
}

std::string wish(const Json &request) {
    if (text(request, "kind") == "mode")
        return "mode " + text(request, "mode");
    const double error = number(request, "max_relative_error");
    const double age = number(request, "max_age_ms");
    return (error > 0 ? fmt::format("error at most {:.4g} %", error) : "") +
           (error > 0 && age > 0 ? ", " : "") +
           (age > 0 ? fmt::format("age at most {:.0f} ms", age) : "");
}

Result<int> show(const Settings &settings) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> requests = list_requests(*daemon);
    if (!requests)
        return requests.error();
    if (settings.json)
        return print_json(*requests);
    for (const Json &request : *requests)
        fmt::print("{}\n", describe_request(request));
    if (requests->empty())
        fmt::print("none\n");
    return 0;
}

} // namespace

Result<Json> list_requests(Daemon &daemon) {
    return daemon.call("ListRequests", "");
}

std::string describe_owner(const Json &request) {
    return fmt::format("{} (pid {:.0f}): {}", user_name(number(request, "user")),
                       number(request, "pid"), text(request, "reason"));
}

std::string describe_request(const Json &request) {
    std::string line = fmt::format("{}, for {:.0f} s by {}", wish(request),
                                   number(request, "since_ms") / 1000, describe_owner(request));
    if (number(request, "kept") == 0)
        line += fmt::format(" (not kept: {})", text(request, "why"));
    return line;
}

Action declare_requests(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return show(settings); };
}

} // namespace afterglow
