// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/sensor_noise.hpp"

#include <span>

namespace afterglow {

/// Readings of about one depth: the median of their pixels' standard deviations in time.
struct DepthBin {
    float z_m = 0;
    float sigma_m = 0;
    int pixels = 0; ///< that the median is of
};

struct NoiseFit {
    SensorNoise noise;
    float misfit = 0; ///< largest |fitted - measured| / measured of the bins
    /// The bins' depths are too much alike for a curve: `noise` is the configured one, multiplied.
    bool scaled = false;
};

/// sigma(z) = floor + linear z + quadratic z^2 that fits the bins best, by their relative errors
/// and with little weight for outliers. It is positive at all depths from half the nearest to twice
/// the farthest, and does not fall in the end (quadratic >= 0). SensorNoise::least_relative is left
/// as configured. `bins`: at least one, by rising depth, sigma_m > 0.
NoiseFit fit_noise(std::span<const DepthBin> bins, const SensorNoise &configured);

} // namespace afterglow
