// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/depth_surface.hpp"

namespace afterglow {

/// Calls of(u, v, z) for some of the surface's readings, z in metres: those on a grid over its
/// picture with the step DepthSurface::sample_step().
template <class Of>
void for_sampled_readings(const DepthSurface &surface, Of &&of) {
    const ImageView<const float> z = surface.z();
    const int step = surface.sample_step();
    for (int v = step / 2; v < z.height(); v += step)
        for (int u = step / 2; u < z.width(); u += step)
            if (z(u, v) != 0.0f)
                of(u, v, z(u, v));
}

} // namespace afterglow
