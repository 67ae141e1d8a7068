// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace afterglow {

/// No camera is taken to see a point nearer than this, metres along its axis.
inline constexpr double nearest_seen_m = 0.05;

/// Pinhole camera, pixels. x right, y down, z forward. The paper's single f and principal-point
/// coordinates (its Eq. 1) are the case fx = fy, cx = cy = 0. Real-time safe.
struct Intrinsics {
    double fx = 0, fy = 0, cx = 0, cy = 0;
    int width = 0, height = 0;

    bool has_size(int w, int h) const { return width == w && height == h; }
    /// The point, in metres, seen at pixel (u, v) at depth z metres along the axis (Eq. 1).
    Eigen::Vector3d back_project(double u, double v, double z) const {
        return {(u - cx) / fx * z, (v - cy) / fy * z, z};
    }
    /// The pixel at which a point in front of the camera (X.z() > 0) is seen (Eq. 2).
    Eigen::Vector2d project(const Eigen::Vector3d &X) const {
        return {fx * X.x() / X.z() + cx, fy * X.y() / X.z() + cy};
    }
    /// Takes a point before the camera to homogeneous pixels.
    Eigen::Matrix3d matrix() const {
        Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
        K(0, 0) = fx;
        K(1, 1) = fy;
        K(0, 2) = cx;
        K(1, 2) = cy;
        return K;
    }
    /// The same camera after its image was halved `level` times, 2x2 pixels to one.
    Intrinsics at_level(int level) const {
        const double s = 1.0 / (1 << level);
        return {fx * s,         fy * s,         (cx + 0.5) * s - 0.5, (cy + 0.5) * s - 0.5,
                width >> level, height >> level};
    }
    bool operator==(const Intrinsics &) const = default;
};

} // namespace afterglow
