// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/warp/corner_kernels.hpp"
#include "core/warp/warp_kernels.hpp"

namespace afterglow {

/// What rows that are read one after the other do to a warp.
struct RollingShutter {
    /// The rows of the surface turn against those of the view, as of Placement::skew, radians.
    Eigen::Vector3f skew = Eigen::Vector3f::Zero();
    /// Motion (v, w) of the scene, the view's frame, while the view is read from the first row to
    /// the last; the pose is that of its middle row. For a surface that was measured all at once.
    Twist motion = Twist::Zero();
};

/// Where a surface's points are seen in a view. Real-time safe.
class SurfaceProjection {
public:
    /// `pose` takes points of the frame of the camera `from`, which has measured the surface, to
    /// that of the view's camera `to`.
    SurfaceProjection(const Intrinsics &from, const Intrinsics &to, const Pose &pose,
                      const RollingShutter &shutter);

    /// Of the points of row v.
    RowProjection row(float v) const;
    /// What happens while the view is read.
    const RowMotion &while_read() const { return motion_; }

    /// Where pixel (u, v) of the surface with depth z, metres, is seen: pixel and depth.
    Eigen::Vector3f operator()(float u, float v, float z) const;
    /// Takes homogeneous pixels of the surface's middle row to those of the view, of points that
    /// are infinitely far away.
    const Eigen::Matrix3f &turn() const { return turn_; }
    /// The points that are seen on row y of the view.
    ViewRow view_row(float y) const;

private:
    /// A point on a ray: its homogeneous pixel is z * ray + shift, the third of which is its depth
    /// in the view, metres.
    struct Line {
        Eigen::Vector3f ray, shift;
        /// Pixel and depth of the point at depth z.
        Eigen::Vector3f seen(float z) const {
            const Eigen::Vector3f h = z * ray + shift;
            const float inverse = 1 / h.z();
            return {h.x() * inverse, h.y() * inverse, h.z()};
        }
    };
    /// The points of pixel (u, v) of the surface, without what happens while the view is read.
    Line line(float u, float v) const;
    /// The same, with what has happened when row `view_row` is read.
    Line line(float u, float v, float view_row) const;
    Eigen::Matrix3f turn_;      ///< takes homogeneous pixels of the surface to those of the view
    Eigen::Matrix3f turn_skew_; ///< is added to it from the middle row to the last, twice
    Eigen::Vector3f shift_;
    RowMotion motion_;
    float rows_;
    float middle_column_; ///< of the view
    bool skewed_;
};

} // namespace afterglow
