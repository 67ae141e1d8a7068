// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "eval/baselines/keypoints.hpp"

#include <Eigen/Core>

#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// A scene point in the later of two images.
struct ScenePoint {
    Eigen::Vector2d pixel;
    double z; ///< along the optical axis; its unit is the way the camera has gone
};

/// Two-view structure from motion (Hartley & Zisserman 2004, ch. 9-12): the fundamental matrix
/// that most pairs agree with, solved again from those by the 8-point algorithm; the motion it
/// holds; and the points that agree with it, triangulated by DLT. Only points in front of both
/// cameras, and not so far off that their rays are all but parallel. Empty when there are too few
/// pairs or they tell of no motion.
std::vector<ScenePoint> triangulate(std::span<const PixelPair> pairs, const Intrinsics &camera);

/// The metres in a unit of `points` with which they best match the true depth: those with the
/// least mean relative error. Nothing when no point has true depth.
std::optional<double> fit_scale(std::span<const ScenePoint> points, DepthView truth);

/// The pixel that a point is in, or nothing when it lies outside an image of that size.
std::optional<Eigen::Vector2i> pixel_of(const ScenePoint &point, int width, int height);

} // namespace afterglow
