// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace afterglow {

/// Rotation matrix of the rotation vector w = theta * k (Rodrigues' formula, Noraky & Sze 2019 Eq. 3).
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
};

} // namespace afterglow
