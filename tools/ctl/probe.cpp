// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/command.hpp"
#include "tools/ctl/devices.hpp"
#include "tools/ctl/print_or_write.hpp"

#include <memory>

namespace afterglow {
namespace {

Result<int> probe(const Settings &settings, const std::string &path) {
    const Result<std::string> configuration = first_configuration(find_devices());
    if (!configuration)
        return configuration.error();
    return print_or_write("configuration", *configuration, path, settings.json);
}

} // namespace

Action declare_probe(CLI::App &app, const Settings &settings) {
    const auto path = std::make_shared<std::string>();
    app.add_option("FILE", *path, "where to write it; stdout if not given")->type_name("");
    return [&settings, path] { return probe(settings, *path); };
}

} // namespace afterglow
