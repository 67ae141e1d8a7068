// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/unit_depth.hpp"

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Pixels of one row of a map, with at least `radius` rows and columns of the map around them.
struct SmoothedRow {
    const UnitDepth *z;    ///< the first of them
    std::ptrdiff_t stride; ///< of the map
    int radius, count;     ///< the radius is 1 to 8
};
/// Metres: means over windows of what lies on the surface of each pixel, as SurfaceSmoothing has
/// them where all readings are of one amplitude. Real-time safe.
void smooth_row(const SmoothedRow &in, const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                float *out);

/// Smoothing with a radius of 2 in two passes, which is nearly the same for a third of the work.
/// They take so many readings of a row at least:
constexpr int least_of_pass = most_units_at_once;
/// The first: each of `count` readings becomes the mean over five of its row, in whole units, less
/// one: no reading is 2^16 - 1. Two readings before `z` and two behind the last are read. `limits`:
/// how far the mean of two opposite readings may be from each, units.
void smooth_row_across(const UnitDepth *z, int count, const SixSigmaFactors &six_sigmas,
                       std::uint16_t *out, UnitDepth *limits);
/// What it makes of a row, with two rows above and two below, `stride` readings apart.
struct ReadingsAcross {
    const std::uint16_t *z;
    std::ptrdiff_t stride;
    const UnitDepth *limits;
};
/// The second: each becomes the mean over five rows, in whole units, as a point of a surface
/// (with_edge_distance()), metres. Both are real-time safe.
void smooth_row_down(const ReadingsAcross &in, int count, const DepthUnits &units,
                     const std::uint8_t *edge_distance, float *out);

} // namespace afterglow
