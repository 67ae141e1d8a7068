// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/held.hpp"

#include <cstdint>
#include <memory>

namespace afterglow {
namespace {

struct Request : Held {
    double error = 0;             ///< percent; 0: no wish
    std::uint32_t max_age_ms = 0; ///< 0: no wish
};

Result<int> request(const Settings &settings, const Request &wanted) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<UniqueFd> wish = daemon->open("RequestAccuracy", "dus", wanted.error,
                                               wanted.max_age_ms, wanted.reason.c_str());
    if (!wish)
        return wish.error();
    return keep(*wish,
                {{"max_relative_error", wanted.error},
                 {"max_age_ms", wanted.max_age_ms},
                 {"reason", wanted.reason}},
                wanted, settings);
}

} // namespace

Action declare_request(CLI::App &app, const Settings &settings) {
    const auto wanted = std::make_shared<Request>();
    auto *wishes = app.add_option_group("wish", "one or both");
    wishes->add_option("--error", wanted->error, "relative error that depth may have at most")
        ->type_name("PERCENT");
    wishes->add_option("--max-age", wanted->max_age_ms, "age that a measurement may have at most")
        ->type_name("MS");
    wishes->require_option(1, 2);
    declare_held(app, *wanted);
    return [&settings, wanted] { return request(settings, *wanted); };
}

} // namespace afterglow
