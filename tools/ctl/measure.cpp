// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/properties.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

Result<int> measure(const Settings &settings) {
    Result<Daemon> daemon = Daemon::connect(settings.bus);
    if (!daemon)
        return daemon.error();
    const Result<Json> frame = daemon->call("Measure", "");
    if (!frame)
        return frame.error();
    if (settings.json)
        return print_json({{"frame", *frame}});
    fmt::print("frame {}\n", with_unit(*frame, ""));
    return 0;
}

} // namespace

Action declare_measure(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return measure(settings); };
}

} // namespace afterglow
