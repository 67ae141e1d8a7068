// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "drivers/simulated/synthetic/scene.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

namespace afterglow {

/// Columns [begin, end) of a row.
struct Columns {
    int begin = 0;
    int end = 0;
};

/// The places (u, v) within half a width and half a height of a centre.
struct Box {
    double u = 0, v = 0;
    double half_width = 0, half_height = 0;
};

/// Where a pixel is sampled that several surfaces share, from its centre.
inline constexpr std::array<std::array<double, 2>, 4> places_in_pixel = {
    {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};

/// a u + b v + c.
struct LinearInPixel {
    double a = 0, b = 0, c = 0;
    double operator()(double u, double v) const { return a * u + b * v + c; }
    /// The most and the least that it is in a box.
    double highest(const Box &box) const { return (*this)(box.u, box.v) + spread(box); }
    double lowest(const Box &box) const { return (*this)(box.u, box.v) - spread(box); }

private:
    double spread(const Box &box) const {
        return std::abs(a) * box.half_width + std::abs(b) * box.half_height;
    }
};

/// Places that are shaded together, on about one line: u, v, and what the pixel's size at each
/// adds to the level of its texture. All of one length.
struct Places {
    std::span<const float> u, v, level;
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
    /// False: it is seen nowhere in the box.
    bool may_be_in(const Box &box) const;
    /// It is seen in the whole of the box, where nothing hides it.
    bool fills(const Box &box) const;
    /// Towards the camera, of length 1.
    Eigen::Vector3d normal() const { return normal_; }
    /// With 8 bits of fraction. `level` is added to the texture's level.
    int luma(double u, double v, float level = 0) const;
    /// Luma and z at each of the places.
    void shade(const Places &places, float *z, std::uint8_t *luma) const;
    /// Luma of the pixels of a row from column u, whose 1/z are given; writes `z` too.
    void shade(int u, int v, std::span<const float> inverse_z, float *z, std::uint8_t *luma) const;

private:
    /// Base-2 logarithm of the pixel's footprint on the texture, in texels.
    float level(double u, double v) const;

    const Texture *texture_;
    bool faces_camera_ = false;
    Eigen::Vector3d normal_;
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
    bool may_be_in(const Box &box) const;
    /// 1/z of its nearest point.
    double highest_inverse_z() const { return 1 / (center_.z() - radius_); }
    Eigen::Vector3d normal(double u, double v) const;
    int luma(double u, double v, float level = 0) const;

private:
    /// In front of the camera as a whole.
    bool is_ahead() const;
    Eigen::Vector3d ray(double u, double v) const;

    const Texture *texture_;
    Intrinsics camera_;
    Eigen::Vector3d center_; ///< in the camera's frame
    double radius_;
    Eigen::Matrix3d to_body_; ///< rotation, in which the pattern rests
    double brightness_;
};

} // namespace afterglow
