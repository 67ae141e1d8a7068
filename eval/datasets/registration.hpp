// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "eval/datasets/lens.hpp"

#include <Eigen/Core>

#include <vector>

namespace afterglow {

/// Draws the depth maps of a depth camera as another camera beside it would have seen them.
///
/// With X = z r(p) the point at pixel p of the depth camera, r its ray through lens and pinhole,
/// the other camera has it at R X + T. Neighbouring pixels are the corners of triangles, so that a
/// surface stays closed whatever the focal lengths; a triangle whose corners differ by more than
/// `surface_step` in depth would join two surfaces, and is left out. Triangles end at the outermost
/// measured points, so silhouettes do not grow; points that are in no triangle (thin things) are
/// drawn as one pixel. The nearest surface wins. Within a triangle 1/z is linear: planes stay
/// planes exactly.
class DepthRegistration {
public:
    /// Neighbours whose depths differ by a larger share of the nearer one lie on two surfaces.
    static constexpr float surface_step = 0.05f;

    /// `depth_to_color` takes points of the depth camera's frame to the colour camera's, metres;
    /// `color` is a pinhole.
    DepthRegistration(const Intrinsics &depth, const LensDistortion &depth_lens,
                      const Pose &depth_to_color, const Intrinsics &color);

    /// `metres`: along the depth camera's axis, of its size, 0 where there is none. Returns
    /// millimetres along the colour camera's axis; 0 where there is none, or more than 65535 mm.
    DepthMap registered(ImageView<const float> metres) const;

private:
    Intrinsics depth_;
    Intrinsics color_;
    Eigen::Vector3d translation_;
    std::vector<Eigen::Vector3d> rays_; // R r(p), row by row
};

} // namespace afterglow
