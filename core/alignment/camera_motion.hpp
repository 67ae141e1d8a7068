// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"
#include "core/base/rigid_motion.hpp"

namespace afterglow {

/// How a held camera moves (one sigma).
struct MotionOptions {
    float speed = 0.2f;                 ///< m/s
    float angular_acceleration = 15.0f; ///< rad/s^2
    /// Longest time from the first to the last row of a picture being read; 0 = global shutter.
    float readout_s = 0.02f;
};

/// Where the camera is and how it moves: constant velocity between images. Poses take world
/// coordinates to the camera's. Real-time safe.
class CameraMotion {
public:
    explicit CameraMotion(const MotionOptions &options) : options_(options) {}

    /// The pose at the last image.
    const Pose &now() const { return now_; }
    /// Motion (v, w) of the scene per second between the last two images; 0 where it is not known.
    Twist rate() const;
    /// The pose expected `dt` seconds after the last image: the last one, if the gap is too long or
    /// the velocity is not known.
    Pose predicted(double dt) const;
    /// Motion within so many seconds from now, at the present velocity.
    Pose moved_in(double seconds) const;
    /// What is known, before looking, of the pose of an image `dt` seconds after the last relative
    /// to one taken `age_s` seconds before it, when rate() was `rate_then`.
    /// `expected`: that relative pose, predicted.
    PosePrior prior(const Pose &expected, const Twist &rate_then, double dt, double age_s) const;

    /// A new image, `dt` seconds after the last. `tracked`: `pose` was observed, so that velocity
    /// can be taken from it.
    void advance(const Pose &pose, bool tracked, double dt);
    /// A better pose for the last image. Velocity stays.
    void correct(const Pose &pose) { now_ = pose; }
    /// The last image's camera is the world's origin now, its velocity unknown.
    void restart();

private:
    MotionOptions options_;
    Pose now_;
    Pose velocity_; ///< motion within velocity_s_ seconds
    double velocity_s_ = 0;
};

} // namespace afterglow
