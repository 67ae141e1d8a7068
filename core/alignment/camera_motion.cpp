// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/camera_motion.hpp"

#include <algorithm>

namespace afterglow {
namespace {

/// After a gap between images longer than this, the velocity predicts nothing, seconds.
constexpr double longest_prediction_s = 0.5;

} // namespace

Pose CameraMotion::predicted(double dt) const {
    return dt > 0 && dt < longest_prediction_s ? moved_in(dt) * now_ : now_;
}

Twist CameraMotion::rate() const {
    return velocity_s_ > 0 ? Twist(log(velocity_) / velocity_s_) : Twist::Zero();
}

Pose CameraMotion::moved_in(double seconds) const {
    return velocity_s_ > 0 ? part_of(velocity_, seconds / velocity_s_) : Pose::identity();
}

PosePrior CameraMotion::prior(const Pose &expected, const Twist &rate_then, double dt,
                              double age_s) const {
    PosePrior prior;
    const double turn_change = (rate() - rate_then).tail<3>().norm(); // rad/s
    prior.skew_rad = options_.readout_s *
                     (static_cast<float>(turn_change) +
                      options_.angular_acceleration * static_cast<float>(std::clamp(dt, 0.0, 0.1)));
    // Where the scene hardly tells a turn from a shift, the camera has rather turned.
    const float reach = options_.speed * static_cast<float>(std::clamp(age_s, 0.01, 10.0));
    prior.mean = Pose{expected.R, Eigen::Vector3d::Zero()};
    prior.information.topLeftCorner<3, 3>().diagonal().setConstant(1.0f / (reach * reach));
    return prior;
}

void CameraMotion::advance(const Pose &pose, bool tracked, double dt) {
    velocity_ = tracked ? pose * now_.inverse() : Pose::identity();
    velocity_s_ = std::max(dt, 0.0);
    now_ = pose;
}

void CameraMotion::restart() {
    now_ = velocity_ = Pose::identity();
}

} // namespace afterglow
