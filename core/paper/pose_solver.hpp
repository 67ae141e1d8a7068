// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/paper/match.hpp"

#include <optional>
#include <span>

namespace afterglow {

/// Squared residual r_i of a match under a pose, square pixels (Noraky & Sze 2019, Eq. 4-5).
///
/// With Y = R X + T the paper's differences of measured and modelled motion reduce to
/// (u_j Y_z - f Y_x) / z and (v_j Y_z - f Y_y) / z, u_j and v_j counted from the principal point:
/// the reprojection error, times Y_z / z.
double squared_residual(const Match &match, const Intrinsics &camera, const Pose &pose);

/// Relative pose of the camera between a depth map and a later image (Noraky & Sze 2019, Eq. 3-6).
///
/// Minimises the mean squared residual over `matches` by Gauss-Newton from no motion, with the
/// Jacobian taken at no rotation throughout: one iteration is the linear least squares of
/// Noraky 2017. Needs at least 3 matches. Returns nothing when the normal equations are
/// rank-deficient (fewer than 3 matches, or points on a line) or a point comes to lie behind the
/// camera. Real-time safe.
std::optional<Pose> solve_pose(std::span<const Match> matches, const Intrinsics &camera,
                               int iterations);

} // namespace afterglow
