// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/sensor_noise.hpp"

#include <cstddef>

namespace afterglow {

/// Pixels of one row of a depth map in metres, 0 = none, with at least `radius` rows and columns of
/// the map around them.
struct SmoothedRow {
    const float *z;        ///< the first of them
    std::ptrdiff_t stride; ///< of the map
    int radius, count;
};

/// Means over windows of what lies on the surface of each pixel, as DepthSurface::smooth() has them
/// where all readings are alike. Real-time safe.
void smooth_row(const SmoothedRow &in, const SensorNoise &noise, float *out);

} // namespace afterglow
