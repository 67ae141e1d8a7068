// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace afterglow {

/// A small rigid motion (v, w): translation in metres, then rotation vector in radians.
using Twist = Eigen::Matrix<double, 6, 1>;

/// Rotation matrix of the rotation vector w = theta * k (Rodrigues' formula, Noraky & Sze 2019
/// Eq. 3).
inline Eigen::Matrix3d rotation(const Eigen::Vector3d &w) {
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

/// Rigid motion of the scene as a camera sees it: a point at X in the first camera's frame is at
/// R X + T in the second's. Metres. Real-time safe.
struct Pose {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d T = Eigen::Vector3d::Zero();

    static Pose identity() { return {}; }
    Eigen::Vector3d operator*(const Eigen::Vector3d &X) const { return R * X + T; }
    /// `*this` after `first` (Noraky & Sze 2019 Eq. 8).
    Pose operator*(const Pose &first) const { return {R * first.R, T + R * first.T}; }
    /// The inverse of a rotation is its transpose: exact only while R is orthonormal, which long
    /// products of poses lose (normalized() restores it).
    Pose inverse() const { return {R.transpose(), -(R.transpose() * T)}; }
    Pose normalized() const { return {Eigen::Quaterniond(R).normalized().toRotationMatrix(), T}; }
    /// Rotation angle in radians.
    double angle() const { return Eigen::AngleAxisd(R).angle(); }
    bool is_finite() const { return R.allFinite() && T.allFinite(); }
    bool operator==(const Pose &other) const { return R == other.R && T == other.T; }
};

/// The pose that turns by w and then shifts by v. Rotation and translation are taken apart: this is
/// the exponential map of SO(3) x R^3, equal to that of SE(3) to first order.
inline Pose exp(const Twist &motion) {
    return {rotation(motion.tail<3>()), motion.head<3>()};
}

/// Inverse of exp(): exp(log(P)) = P for angles up to pi.
inline Twist log(const Pose &pose) {
    const Eigen::AngleAxisd turn(pose.R);
    Twist motion;
    motion << pose.T, turn.axis() * turn.angle();
    return motion;
}

/// Takes a small motion applied before `pose` to the same applied after it, to first order:
/// pose * exp(x) = exp(adjoint(pose) * x) * pose. v' = R v + T x R w and w' = R w.
inline Eigen::Matrix<double, 6, 6> adjoint(const Pose &pose) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = pose.R;
    for (int i = 0; i < 3; ++i)
        A.block<3, 1>(0, 3 + i) = pose.T.cross(pose.R.col(i));
    return A;
}

/// The part of a motion made in `share` of its time at constant rates: 0 is none, 1 all of it; less
/// than 0 and more than 1 extrapolate.
inline Pose part_of(const Pose &motion, double share) {
    const Eigen::AngleAxisd turn(motion.R);
    return {rotation(turn.axis() * (turn.angle() * share)), motion.T * share};
}

} // namespace afterglow
