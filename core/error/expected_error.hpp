// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rigid_motion.hpp"
#include "core/base/views.hpp"
#include "core/surface/depth_surface.hpp"

#include <Eigen/Core>

#include <array>

namespace afterglow {

struct ErrorOptions {
    /// Misplacement of a depth edge in the sensor's own maps, pixels (Kinect-class: 1 to 2).
    float edge_registration_px = 1.2f;
    /// Jitter of the lag from an image to its depth map, seconds, one sigma.
    float lag_jitter_s = 0.0015f;
    /// Part of a sensor's depth error that smoothing does not remove.
    float shared_noise = 0.7f;
    /// Relative error that the gate assumes of a pixel that has no depth because something moved
    /// there.
    float moving_error = 0.05f;
};

/// How wrong one carried map is expected to be; everything a per-pixel error needs.
struct MapError {
    float pose_relative = 0; ///< depth error by pose error, share of depth, one sigma
    float shift_px = 0;      ///< image position error, one sigma
    float slope = 0;         ///< |dz|/z per pixel inside surfaces
    /// Share of the depth, of a calibration that is known to be wrong. Maps agree about it, so that
    /// measurements cannot tell: it is not part of pixel_error().
    float misplaced = 0;
    std::array<float, 8> edge{};       ///< expected relative error by distance from a depth edge
    std::array<float, 8> fresh_edge{}; ///< the same of a map that has not been carried
};

/// Covariance of the motion (v, w) by which jitter of the lag misplaces a keyframe's map against
/// one measured now: both are exposed `lag_jitter_s`, one sigma, earlier or later than assumed.
/// Metres and radians, in the tracking camera's frame at the keyframe. `then`, `now`:
/// CameraMotion::rate() at the keyframe and now; `pose` takes points from the tracking camera's
/// frame at the keyframe to its frame now.
Eigen::Matrix<float, 6, 6> lag_covariance(const Twist &then, const Twist &now, const Pose &pose,
                                          float lag_jitter_s);

/// Of a map that has not been carried. `camera`: the surface camera. `calibration_shift`: by how
/// much the directions of images may be wrong, radians, one sigma.
MapError fresh_map_error(const DepthSurface &surface, const Intrinsics &camera,
                         const ErrorOptions &options, float calibration_shift = 0);

/// Carries the uncertainty of a pose into depth.
///
/// A plane n.X = 1 seen at a fixed pixel changes its depth by dz/z = n.(v + w x X) under the motion
/// (v, w); with covariance C of (v, w), var(dz/z) = a C a^T, a = [n, X x n]. The same motion shifts
/// image points by J_pi [I, -[X]x] (v, w); where the depth jumps or slopes, a shift costs
/// |grad z| / z times its length. Both are averaged over the sampled readings that are in view;
/// where none is, the map is taken to be wrong by its whole depth. `calibration_shift`: as of
/// fresh_map_error(). `pose` takes points of the surface camera's frame to the published camera's;
/// the motion is one of the tracking camera, before it.
MapError map_error(const DepthSurface &surface, const Views &views, const Pose &pose,
                   const Eigen::Matrix<float, 6, 6> &covariance, const ErrorOptions &options,
                   float calibration_shift = 0);

/// Factors on the two parts of a pixel's error.
struct ErrorScales {
    float fresh = 1;   ///< on that of a map just measured
    float carried = 1; ///< on what carrying it adds, in quadrature

    bool operator==(const ErrorScales &) const = default;
};

/// The errors of a TOF camera are correlated between near views. This is the part of a fresh map's
/// error that shows when the map is compared with another one, as a share of it, one sigma.
/// `displacement`: of the scene's image between the two, radians.
float uncorrelated_share(float displacement);

/// Expected relative error of one pixel of a carried map against a fresh reading.
struct PixelError {
    float fresh = 0;    ///< that of a map just measured
    float carried2 = 0; ///< square of what carrying it adds, in quadrature

    float scaled(const ErrorScales &scales) const;
};
/// `z`: metres; `edge_distance`: pixels.
PixelError pixel_error(const MapError &map, const SensorNoise &noise, float shared_noise, float z,
                       int edge_distance);

} // namespace afterglow
