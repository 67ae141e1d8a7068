// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/scene.hpp"

#include <array>
#include <cstdint>
#include <span>

namespace afterglow {

/// Columns [begin, end) of a row.
struct Columns {
    int begin = 0;
    int end = 0;
};

/// a u + b v + c.
struct LinearInPixel {
    double a = 0, b = 0, c = 0;
    double operator()(double u, double v) const { return a * u + b * v + c; }
};

/// A rectangle as a camera sees it. Pixels (u, v) may be anywhere, not only on centres.
///
/// With the ray d(u, v) = ((u - cx) / fx, (v - cy) / fy, 1), a corner o, unit edges r, e and their
/// normal n, all in the camera's frame, the ray meets the plane at depth z = n.o / n.d. Thus
///     1/z = n.d / n.o,   s/z = r.d - (r.o)/z,   t/z = e.d - (e.o)/z,
/// where (s, t) is the place on the rectangle in metres.
class PlaneView {
public:
    PlaneView(const Quad &quad, const Texture &texture, const Pose &body_to_camera,
              const Intrinsics &camera);

    /// Whether the camera sees its front at all.
    bool faces_camera() const { return faces_camera_; }
    /// Pixel centres of row v in which it is seen, of `width` columns.
    Columns columns(int v, int width) const;
    /// 1/z; meaningful where it is seen.
    const LinearInPixel &inverse_z() const { return inverse_z_; }
    /// 1/z, or 0 where it is not seen.
    double inverse_z_if_seen(double u, double v) const;
    int luma(double u, double v) const;
    /// Luma of the pixels of a row from column u, whose 1/z are given; writes `z` too.
    void shade(int u, int v, std::span<const float> inverse_z, float *z, std::uint8_t *luma) const;

private:
    /// Base-2 logarithm of the pixel's footprint on the texture, in texels.
    float level(double u, double v) const;

    const Texture *texture_;
    bool faces_camera_ = false;
    LinearInPixel inverse_z_, s_over_z_, t_over_z_;
    std::array<LinearInPixel, 6> seen_where_; ///< none is negative where the front is seen
    float offset_s_, offset_t_;
    int brightness_; ///< 256 = as the texture is
};

/// A sphere as a camera sees it.
class BallView {
public:
    BallView(const Sphere &sphere, const Texture &texture, const Pose &body_to_camera,
             const Intrinsics &camera);

    Columns columns(int v, int width) const;
    double inverse_z_if_seen(double u, double v) const;
    int luma(double u, double v) const;

private:
    Eigen::Vector3d ray(double u, double v) const;

    const Texture *texture_;
    Intrinsics camera_;
    Eigen::Vector3d center_; ///< in the camera's frame
    double radius_;
    Eigen::Matrix3d to_body_; ///< rotation, in which the pattern rests
    double brightness_;
};

} // namespace afterglow
