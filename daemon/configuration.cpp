// SPDX-License-Identifier: Apache-2.0
#include "daemon/configuration.hpp"

#include "config/parameter_table.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>

namespace afterglow {
namespace {

constexpr std::array<std::string_view, 4> live_prefixes{"gate.", "power.", "access.",
                                                        "daemon.linger_s"};
constexpr std::array<std::string_view, 10> calibration{
    "color.fx",     "color.fy",     "color.cx",     "color.cy",     "rig.calibration",
    "published.fx", "published.fy", "published.cx", "published.cy", "published.camera"};

RigGeometry geometry(const Config &config) {
    return rig_geometry(config).value_or(RigGeometry(config.color.camera));
}

} // namespace

Result<Config> read_configuration(const ConfigurationFiles &files) {
    Result<Config> config = load_config(files.config, files.policy);
    if (config && !files.bus.empty())
        config->daemon.bus = files.bus;
    return config;
}

std::optional<RigGeometry> live_geometry(const Config &running, const Config &read) {
    const ColorDriver driver = running.color.driver;
    const bool is_real = driver == ColorDriver::v4l2 || driver == ColorDriver::libcamera;
    const RigGeometry before = geometry(running), now = geometry(read);
    if (!is_real || read.color.driver != driver || before.registered != now.registered ||
        !before.same_sizes(now))
        return std::nullopt;
    return now;
}

std::vector<std::string> restart_needed(Config running, Config read) {
    const bool calibration_is_live = live_geometry(running, read).has_value();
    const auto is_live = [&](std::string_view key) {
        return std::any_of(live_prefixes.begin(), live_prefixes.end(),
                           [&](std::string_view prefix) { return key.starts_with(prefix); }) ||
               (calibration_is_live &&
                std::find(calibration.begin(), calibration.end(), key) != calibration.end());
    };
    const ParameterTable before = ParameterTable::of(running);
    const ParameterTable now = ParameterTable::of(read);
    std::vector<std::string> keys;
    for (const Parameter &row : before.rows())
        if (!is_live(row.key) && toml_value(row) != toml_value(*now.find(row.key)))
            keys.emplace_back(row.key);
    return keys;
}

} // namespace afterglow
