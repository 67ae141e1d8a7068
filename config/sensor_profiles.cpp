// SPDX-License-Identifier: Apache-2.0
#include "config/sensor_profiles.hpp"

#include <algorithm>
#include <array>

namespace afterglow {
namespace {

constexpr SurfaceOptions usual{};

constexpr std::array profiles = {
    SensorProfile{"kinect", usual.noise, usual.nearest_m, usual.farthest_m},
    SensorProfile{"kinect-v2", {0.0015F, -0.0005F, 0.0003F}, 0.5F, 4.5F},
    SensorProfile{"azure-kinect-nfov", {0, 0.0009F, 0.0001F}, 0.5F, 5.46F},
    SensorProfile{"azure-kinect-wfov", {0, 0.0016F, 0.00018F}, 0.25F, 2.88F},
    SensorProfile{"femto", {0, 0.0009F, 0.0001F}, 0.5F, 5.46F},
    SensorProfile{"l515", {0.0009F, 0.0016F, 0}, 0.25F, 9.0F},
    SensorProfile{"pmd-small", {0, 0.01F, 0}, 0.1F, 4.0F},
};

constexpr auto names = [] {
    std::array<std::string_view, profiles.size()> of_profiles;
    for (std::size_t i = 0; i < profiles.size(); ++i)
        of_profiles[i] = profiles[i].name;
    return of_profiles;
}();

} // namespace

std::span<const SensorProfile> sensor_profiles() {
    return profiles;
}

std::span<const std::string_view> sensor_profile_names() {
    return names;
}

const SensorProfile *find_sensor_profile(std::string_view name) {
    const auto *const profile = std::ranges::find(profiles, name, &SensorProfile::name);
    return profile == profiles.end() ? nullptr : profile;
}

} // namespace afterglow
