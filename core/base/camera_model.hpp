// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>

namespace afterglow {

/// How a lens bends rays, by the names that ROS and OpenCV use.
enum class Lens : std::uint8_t {
    pinhole = 0,        ///< not at all
    brown_conrady = 1,  ///< OpenCV's rational model: k1 k2 p1 p2 k3 k4 k5 k6, later ones 0
    kannala_brandt = 2, ///< OpenCV's fisheye model: k1 k2 k3 k4
};

/// A camera with its lens. A ray is a point at depth 1, (X / Z, Y / Z): less than 90 degrees off
/// the axis. With r^2 = x^2 + y^2 of the ray (x, y) and theta = atan r, the pixel is that at which
/// `pinhole` sees
///
///   Brown and Conrady:  x' = x s + 2 p1 x y + p2 (r^2 + 2 x^2),  y' likewise,
///                       s = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
///   Kannala and Brandt: (x', y') = (x, y) theta (1 + k1 theta^2 + ... + k4 theta^8) / r
///
/// (Brown 1966; Kannala and Brandt, PAMI 2006.) Real-time safe.
struct CameraModel {
    Intrinsics pinhole{};
    Lens lens = Lens::pinhole;
    std::array<double, 8> distortion{};

    /// The pixel at which a point in front of the camera is seen. Polynomials turn back far off the
    /// axis: a point there may get a pixel that ray() gives to another one.
    Eigen::Vector2d project(const Eigen::Vector3d &X) const;
    /// The ray that is seen at pixel (u, v). Nothing where the lens shows none.
    std::optional<Eigen::Vector2d> ray(double u, double v) const;

    bool operator==(const CameraModel &) const = default;
};

} // namespace afterglow
