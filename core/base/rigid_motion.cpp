// SPDX-License-Identifier: Apache-2.0
#include "core/base/rigid_motion.hpp"

#include <Eigen/Geometry>

namespace afterglow {

Eigen::Matrix3d rotation(const Eigen::Vector3d &w) {
    const double theta = w.norm();
    if (theta < 1e-12) {
        Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
        R(0, 1) = -w.z();
        R(0, 2) = w.y();
        R(1, 0) = w.z();
        R(1, 2) = -w.x();
        R(2, 0) = -w.y();
        R(2, 1) = w.x();
        return R;
    }
    return Eigen::AngleAxisd(theta, w / theta).toRotationMatrix();
}

Pose Pose::operator*(const Pose &first) const {
    return {R * first.R, T + R * first.T};
}

Pose Pose::inverse() const {
    return {R.transpose(), -(R.transpose() * T)};
}

Pose Pose::normalized() const {
    return {Eigen::Quaterniond(R).normalized().toRotationMatrix(), T};
}

double Pose::angle() const {
    return Eigen::AngleAxisd(R).angle();
}

bool Pose::is_finite() const {
    return R.allFinite() && T.allFinite();
}

bool Pose::operator==(const Pose &other) const {
    return R == other.R && T == other.T;
}

Pose exp(const Twist &motion) {
    return {rotation(motion.tail<3>()), motion.head<3>()};
}

Twist log(const Pose &pose) {
    const Eigen::AngleAxisd turn(pose.R);
    Twist motion;
    motion << pose.T, turn.axis() * turn.angle();
    return motion;
}

Eigen::Matrix<double, 6, 6> adjoint(const Pose &pose) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = pose.R;
    for (int i = 0; i < 3; ++i)
        A.block<3, 1>(0, 3 + i) = pose.T.cross(pose.R.col(i));
    return A;
}

Pose part_of(const Pose &motion, double share) {
    const Eigen::AngleAxisd turn(motion.R);
    return {rotation(turn.axis() * (turn.angle() * share)), motion.T * share};
}

} // namespace afterglow
