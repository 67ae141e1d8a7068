// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace afterglow {

/// A small rigid motion (v, w): translation in metres, then rotation vector in radians.
using Twist = Eigen::Matrix<double, 6, 1>;

/// Rotation matrix of the rotation vector w = theta * k (Rodrigues' formula, Noraky & Sze 2019
/// Eq. 3).
Eigen::Matrix3d rotation(const Eigen::Vector3d &w);

/// Rigid motion of the scene as a camera sees it: a point at X in the first camera's frame is at
/// R X + T in the second's. Metres. Real-time safe.
struct Pose {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d T = Eigen::Vector3d::Zero();

    static Pose identity() { return {}; }
    Eigen::Vector3d operator*(const Eigen::Vector3d &X) const { return R * X + T; }
    /// `*this` after `first` (Noraky & Sze 2019 Eq. 8).
    Pose operator*(const Pose &first) const;
    /// The inverse of a rotation is its transpose: exact only while R is orthonormal, which long
    /// products of poses lose (normalized() restores it).
    Pose inverse() const;
    Pose normalized() const;
    /// Rotation angle in radians.
    double angle() const;
    bool is_finite() const;
    bool operator==(const Pose &other) const;
};

/// The pose that turns by w and then shifts by v. Rotation and translation are taken apart: this is
/// the exponential map of SO(3) x R^3, equal to that of SE(3) to first order.
Pose exp(const Twist &motion);

/// Inverse of exp(): exp(log(P)) = P for angles up to pi.
Twist log(const Pose &pose);

/// Takes a small motion applied before `pose` to the same applied after it, to first order:
/// pose * exp(x) = exp(adjoint(pose) * x) * pose. v' = R v + T x R w and w' = R w.
Eigen::Matrix<double, 6, 6> adjoint(const Pose &pose);

/// The part of a motion made in `share` of its time at constant rates: 0 is none, 1 all of it; less
/// than 0 and more than 1 extrapolate.
Pose part_of(const Pose &motion, double share);

} // namespace afterglow
