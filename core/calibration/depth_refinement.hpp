// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/calibration/self_calibration.hpp"
#include "core/surface/depth_surface.hpp"

#include <Eigen/Core>

namespace afterglow {

/// What comparing two measured surfaces told.
struct DepthFit {
    Pose pose;
    float residual_scale = 0; ///< median |z difference| / sensor sigma, as a Gaussian's sigma
    float inlier_share = 0;   ///< of the compared points: difference below 4 sensor sigmas
    /// Mean of |z difference| / z of the compared points, each counting for 0.2 and for 12 times
    /// the residual scale at most; 0 if there are too few.
    float relative_error = 0;
    bool good = false;
};

struct DepthRefinementOptions {
    int iterations = 10;
    float least_inlier_share = 0.5f;
    /// Weight of the start pose: the deviation within which it is trusted, metres and radians.
    float start_m = 0.05f;
    float start_rad = 0.03f;
};

/// Refines the pose between two measured depth maps by their geometry: projective data
/// association, difference of depths along the current camera's rays,
///
///   minimise sum_i rho((D(pi(T X_i)) - [T X_i]_z) / sigma(z_i)) + |start - T|^2 weighted,
///
/// linearised with the gradient of D. Used when a measurement arrives, to tie the new map to the
/// earlier ones, and by the oracle. Real-time safe.
DepthFit refine_by_depth(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                         const Pose &start, const Eigen::Matrix<float, 6, 6> &start_information,
                         const DepthRefinementOptions &options = {});

/// What a pair of maps tells of the TOF camera's calibration.
///
/// With the pose known to within `start_information` from images, what is left between the maps
/// `from` and `to` at the pose of their `fit` is laid to the shape of both and to the lag of their
/// exposures: a camera whose turning rate has changed by `rate_change` (rad/s, current frame) since
/// `from` has turned lag * rate_change further by depth than by images. `lag_s`: what `start`
/// already allows for. One Gauss-Newton step over motion, shape and lag, the motion eliminated.
/// Real-time safe.
CalibrationEvidence calibration_evidence(const DepthSurface &from, const DepthSurface &to,
                                         const Intrinsics &camera, const DepthFit &fit,
                                         const Pose &start,
                                         const Eigen::Matrix<float, 6, 6> &start_information,
                                         const Eigen::Vector3d &rate_change, double lag_s);

} // namespace afterglow
