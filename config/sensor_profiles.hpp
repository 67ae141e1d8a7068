// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/depth_surface.hpp"

#include <span>
#include <string_view>

namespace afterglow {

/// A family of TOF cameras: the noise along Z of one reading and the range in which there are
/// readings. docs/sensors.md has the source of each number.
struct SensorProfile {
    std::string_view name; ///< as `sensor.profile` has it
    SensorNoise noise;
    float nearest_m = 0;
    float farthest_m = 0;

    void apply(SurfaceOptions &surface) const {
        surface.noise = noise;
        surface.nearest_m = nearest_m;
        surface.farthest_m = farthest_m;
    }
};

/// All of them; the first is what SurfaceOptions are made with.
std::span<const SensorProfile> sensor_profiles();
/// The same, by name alone.
std::span<const std::string_view> sensor_profile_names();
/// Null: there is none of that name.
const SensorProfile *find_sensor_profile(std::string_view name);

} // namespace afterglow
