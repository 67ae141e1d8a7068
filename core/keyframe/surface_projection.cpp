// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_projection.hpp"

#include <Eigen/LU>

#include <algorithm>

namespace afterglow {
namespace {

/// The cross product with w.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d &w) {
    Eigen::Matrix3d cross;
    cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    return cross;
}

} // namespace

SurfaceProjection::SurfaceProjection(const Intrinsics &from, const Intrinsics &to, const Pose &pose,
                                     const RollingShutter &shutter)
    : rows_(static_cast<float>(from.height)), skewed_(!shutter.skew.isZero(0)) {
    const Eigen::Matrix3d K = to.matrix(), Ki = from.matrix().inverse();
    turn_ = (K * pose.R * Ki).cast<float>();
    // Skews are so small that their squares do not matter.
    turn_skew_ = (K * pose.R * cross_matrix(shutter.skew.cast<double>()) * Ki).cast<float>();
    shift_ = (K * pose.T).cast<float>();
    motion_ = {(K * cross_matrix(shutter.motion.tail<3>()) * K.inverse()).cast<float>(),
               (K * shutter.motion.head<3>()).cast<float>(),
               static_cast<float>((to.height - 1) / 2.0), 1 / static_cast<float>(to.height),
               !shutter.motion.isZero(0)};
}

SurfaceProjection::Line SurfaceProjection::line(float u, float v) const {
    const Eigen::Vector3f pixel{u, v, 1};
    Eigen::Vector3f ray = turn_ * pixel;
    if (skewed_)
        ray += (v / rows_ - 0.5f) * (turn_skew_ * pixel);
    return {ray, shift_};
}

SurfaceProjection::Line SurfaceProjection::line(float u, float v, float view_row) const {
    Line line = this->line(u, v);
    if (motion_.any) {
        const float part =
            std::min(std::max((view_row - motion_.middle) * motion_.per_row, -0.5f), 0.5f);
        line = {line.ray + part * (motion_.turn * line.ray),
                line.shift + part * (motion_.turn * line.shift + motion_.shift)};
    }
    return line;
}

Eigen::Vector3f SurfaceProjection::operator()(float u, float v, float z) const {
    const Eigen::Vector3f seen = line(u, v).seen(z);
    return motion_.any ? line(u, v, seen.y()).seen(z) : seen;
}

Eigen::Matrix2f SurfaceProjection::jacobian(const Eigen::Vector3f &seen, float z) const {
    return z / seen.z() * (turn_.topLeftCorner<2, 2>() - seen.head<2>() * turn_.row(2).head<2>());
}

RowProjection SurfaceProjection::row(float v) const {
    const float part = skewed_ ? v / rows_ - 0.5f : 0;
    const Eigen::Matrix3f A = turn_ + part * turn_skew_;
    return {A.col(0), A.col(1) * v + A.col(2), shift_};
}

} // namespace afterglow
