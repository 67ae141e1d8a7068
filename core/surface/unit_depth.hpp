// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/sensor_noise.hpp"

#include <cstdint>

namespace afterglow {

/// A depth in whole units of a map: 1 / DepthUnits::per_metre; 0 = none.
using UnitDepth = std::int16_t;

/// The fraction of a metre that a map's depths are counted in: half a millimetre as far as it
/// reaches, else one. Sums of two depths less twice a third stay clear of 2^16, so that what
/// overflows is never taken for a small difference.
struct DepthUnits {
    static constexpr float farthest_m = 30.0f;
    static constexpr float farthest_of_halves_m = 15.0f;

    explicit DepthUnits(float reach_m) : halves(reach_m <= farthest_of_halves_m) {}

    bool halves; ///< of millimetres

    int per_millimetre() const { return halves ? 2 : 1; }
    float per_metre() const { return halves ? 2000.0f : 1000.0f; }
    float metres() const { return halves ? 0.0005f : 0.001f; }
};

/// SensorNoise::sigma() of depths in units and in units.
SensorNoise in_units(const SensorNoise &noise, const DepthUnits &units);

/// Six times a sensor's sigma() of depths in a map's units, as a sum of 16-bit fixed-point
/// products. Where a factor is 1 or more, all are divided by a power of two, and the sum is doubled
/// as often.
struct SixSigmaFactors {
    SixSigmaFactors(const SensorNoise &noise, const DepthUnits &units);

    int doublings = 0;
    std::int16_t floor, linear, quadratic, least;
};

/// Kernels take at most so many depths of a row at once.
constexpr int most_units_at_once = 32;
/// They read this many depths and steps past the end of a row: a vector, and the largest radius of
/// smoothing. What is there is not used.
constexpr int row_slack = most_units_at_once + 8;

} // namespace afterglow
