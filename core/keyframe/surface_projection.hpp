// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/keyframe/warp_kernels.hpp"

namespace afterglow {

/// What rows that are read one after the other do to a warp.
struct RollingShutter {
    /// The rows of the surface turn against those of the view, as of Placement::skew, radians.
    Eigen::Vector3f skew = Eigen::Vector3f::Zero();
    /// Motion (v, w) of the scene, the view's frame, while the view is read from the first row to
    /// the last; the pose is that of its middle row. For a surface that was measured all at once.
    Twist motion = Twist::Zero();
};

/// The points of a surface that are seen at one pixel of a view.
struct ViewRay {
    Eigen::Vector2f infinite =
        Eigen::Vector2f::Zero(); ///< the pixel of those that are infinitely far away
    Eigen::Vector2f parallax =
        Eigen::Vector2f::Zero(); ///< what nearer ones are beside it, pixels times metres
    float scale = 0, shift = 0;  ///< their depth in the view is scale z + shift; shift in metres

    /// The pixel of the surface whose point is seen if its depth is z, metres.
    Eigen::Vector2f place(float z) const { return infinite + (1 / z) * parallax; }
    float depth(float z) const { return scale * z + shift; }
};

/// What is seen on one row of a view. The inverse of SurfaceProjection, but for two things: along
/// parallax a surface's skew is taken to be that of points infinitely far away, and the motion
/// while the view is read is that of the row itself, not of the one on which a point would be
/// without it.
class ViewRow {
public:
    ViewRay at(float column) const;

private:
    friend class SurfaceProjection;
    /// By y depth, a homogeneous pixel (column, row, 1) of the view becomes y (by_column_ column +
    /// origin_) - shift_, a homogeneous pixel of the surface.
    Eigen::Vector3f by_column_, origin_, shift_;
    /// How surface pixels turn from its first row to its last one, per row from `middle_` on.
    Eigen::Matrix3f turn_per_row_;
    float middle_;
    bool skewed_;
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
