// SPDX-License-Identifier: Apache-2.0
#include "daemon/configuration.hpp"

#include "config/parameter_table.hpp"

#include <algorithm>
#include <array>
#include <string_view>

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
    const RigGeometry before = geometry(running);
    RigGeometry now = geometry(read);
    now.rig.tof_delay_s = before.rig.tof_delay_s; // maps and images are paired as at the start
    if (!is_real || read.color.driver != driver || before.registered != now.registered ||
        !before.same_sizes(now))
        return std::nullopt;
    return now;
}

std::vector<std::string> restart_needed(Config running, Config read) {
    const std::optional<RigGeometry> live = live_geometry(running, read);
    const auto is_live = [&](std::string_view key) {
        return std::any_of(live_prefixes.begin(), live_prefixes.end(),
                           [&](std::string_view prefix) { return key.starts_with(prefix); }) ||
               (live &&
                std::find(calibration.begin(), calibration.end(), key) != calibration.end());
    };
    const ParameterTable before = ParameterTable::of(running);
    const ParameterTable now = ParameterTable::of(read);
    // A file that says something else is one key, whatever it stands for.
    const bool has_file = running.calibration.rig || read.calibration.rig;
    const bool file_waits =
        live ? !(live->rig == geometry(read).rig) : running.calibration.rig != read.calibration.rig;
    const auto needs_restart = [&](const Parameter &row) {
        if (row.key == "rig.calibration" && file_waits)
            return true;
        return !is_live(row.key) && !(has_file && is_of_calibration_file(row.key)) &&
               toml_value(row) != toml_value(*now.find(row.key));
    };
    std::vector<std::string> keys;
    for (const Parameter &row : before.rows())
        if (needs_restart(row))
            keys.emplace_back(row.key);
    return keys;
}

} // namespace afterglow
