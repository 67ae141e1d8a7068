// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/result.hpp"
#include "core/base/rigid_motion.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/find_board.hpp"
#include "tools/calibrate/residuals.hpp"

#include <Eigen/Core>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace afterglow {

/// Corners are not believed to be found better than this, in exact pictures neither.
inline constexpr double least_noise_px = 0.005;

/// One camera from pictures of a board.
struct CameraFit {
    LensModel model;
    CameraModel camera;
    std::vector<Pose> board_to_camera; ///< one for each view
    double noise_px = 0;               ///< standard deviation of a corner's u or v
    double focal_sigma = 0;            ///< standard deviation, as a share of it
    double center_sigma_px = 0;        ///< of the principal point
};

/// The pose of a board whose corners are seen; at least four are known to be in front.
std::optional<Pose> board_pose(const Board &board, const Corners &corners,
                               const CameraModel &camera);

/// Fits a camera of `width` x `height` to its views, none of them empty. Without `wanted`, the
/// simplest lens is taken whose residuals are no more than 3 percent larger than the best one's.
/// Errors: what the views lack.
Result<CameraFit> fit_camera(const Board &board, std::span<const Corners> views, int width,
                             int height, const std::optional<Lens> &wanted);

/// The largest angle between any two of the boards' normals, degrees.
double tilt_range(std::span<const Pose> board_to_camera);

} // namespace afterglow
