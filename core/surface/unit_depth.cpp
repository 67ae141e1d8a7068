// SPDX-License-Identifier: Apache-2.0
#include "core/surface/unit_depth.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {

SensorNoise in_units(const SensorNoise &noise, const DepthUnits &units) {
    return {noise.floor_m * units.per_metre(), noise.linear, noise.quadratic_per_m * units.metres(),
            noise.least_relative};
}

SixSigmaFactors::SixSigmaFactors(const SensorNoise &noise, const DepthUnits &units) {
    constexpr int most_doublings = 15;
    const SensorNoise six = in_units(noise, units).times(6);
    const float of_square = 32768 * six.quadratic_per_m; // over 2^15
    const float most = std::max(
        {std::abs(six.linear), std::abs(of_square), six.least_relative, six.floor_m / 32768});
    while (std::ldexp(most, -doublings) >= 1 && doublings < most_doublings)
        ++doublings;
    const auto part = [&](float factor) {
        return static_cast<std::int16_t>(
            std::lround(std::clamp(32768 * std::ldexp(factor, -doublings), -32767.0f, 32767.0f)));
    };
    floor = part(six.floor_m / 32768);
    linear = part(six.linear);
    quadratic = part(of_square);
    least = part(six.least_relative);
}

} // namespace afterglow
