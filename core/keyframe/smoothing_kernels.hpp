// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/unit_depth.hpp"

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
/// The first: each of `count` readings becomes the mean over five of its row, in whole units, less
/// one: no reading is 2^16 - 1. Two readings before `z` and two behind the last are read.
void smooth_row_across(const UnitDepth *z, int count, const SixSigmaFactors &six_sigmas,
                       std::uint16_t *out);
/// The second: each reading becomes the mean over five rows of such means, metres, as a point of a
/// surface (with_edge_distance()). Rows are `stride` readings apart; two above `z` and two below
/// are read. Both are real-time safe.
void smooth_row_down(const std::uint16_t *z, std::ptrdiff_t stride, int count,
                     const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                     const std::uint8_t *edge_distance, float *out);

} // namespace afterglow
