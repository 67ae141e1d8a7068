// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace afterglow {

/// How a TOF camera's maps differ from what a pinhole camera, exposed with the images, would
/// measure. Depth registered to colour still counts along the TOF camera's own axis, and a lens or
/// a range that is not quite linear bends it.
struct DepthCorrection {
    /// The true depth at (X/Z, Y/Z) = (x, y) is the reading times 1 + shape . (x, y, x^2 + y^2).
    Eigen::Vector3f shape = Eigen::Vector3f::Zero();
    /// Seconds by which a depth map is exposed after its image.
    double lag_s = 0;

    static Eigen::Vector3f basis(float x, float y) { return {x, y, x * x + y * y}; }
    float scale(float x, float y) const { return 1.0f + shape.dot(basis(x, y)); }
};

} // namespace afterglow
