// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/camera.hpp"
#include "core/depth_surface.hpp"
#include "core/pose.hpp"

#include <Eigen/Core>

namespace afterglow {

/// What comparing two measured surfaces told.
struct DepthFit {
    Pose pose;
    float residual_scale = 0; ///< median |z difference| / sensor sigma, as a Gaussian's sigma
    float inlier_share = 0;   ///< of the compared points: difference below 4 sensor sigmas
    float compared_share = 0; ///< of the sampled points: seen with depth in both
    bool good = false;
};

struct DepthRefinementOptions {
    int grid_px = 4;
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

} // namespace afterglow
