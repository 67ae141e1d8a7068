// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"

#include <Eigen/Core>

namespace afterglow {

/// How a lens bends rays: Brown's model with the coefficients that OpenCV and Bouguet's toolbox
/// call k1 k2 p1 p2 k3. All zero: a pinhole. Points are X/Z, Y/Z.
struct LensDistortion {
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

    /// Where the lens puts a point that a pinhole would put at `x`.
    Eigen::Vector2d distort(const Eigen::Vector2d &x) const;
    /// The inverse, to within 1e-9 for lenses as mild as those of depth cameras.
    Eigen::Vector2d undistort(const Eigen::Vector2d &x) const;
};

/// The image that a pinhole with the same intrinsics would have taken: bilinear, with the edge
/// pixels repeated where the lens saw nothing.
Luma undistorted(LumaView image, const Intrinsics &camera, const LensDistortion &lens);

} // namespace afterglow
