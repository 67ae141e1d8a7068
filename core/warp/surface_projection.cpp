// SPDX-License-Identifier: Apache-2.0
#include "core/warp/surface_projection.hpp"

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
    : rows_(static_cast<float>(from.height)), middle_column_(static_cast<float>(to.width - 1) / 2),
      skewed_(!shutter.skew.isZero(0)) {
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

ViewRow SurfaceProjection::view_row(float y) const {
    const float part =
        motion_.any ? std::clamp((y - motion_.middle) * motion_.per_row, -0.5f, 0.5f) : 0;
    const Eigen::Matrix3f moved = Eigen::Matrix3f::Identity() + part * motion_.turn;
    const Eigen::Vector3f shift = moved * shift_ + part * motion_.shift;
    ViewRow row;
    row.skewed = skewed_;
    row.middle = 0.5f * rows_;
    const auto turn_back_at = [&](float surface_row) -> Eigen::Matrix3f {
        const Eigen::Matrix3f ahead = turn_ + (surface_row / rows_ - 0.5f) * turn_skew_;
        return (moved * ahead).cast<double>().inverse().cast<float>();
    };
    Eigen::Matrix3f back = turn_back_at(row.middle);
    if (skewed_) {
        const Eigen::Vector3f at_middle = back * Eigen::Vector3f(middle_column_, y, 1);
        row.middle = at_middle.y() / at_middle.z();
        back = turn_back_at(row.middle);
        row.turn_per_row = back * moved * turn_skew_ / rows_;
    }
    row.by_column = back.col(0);
    row.origin = back.col(1) * y + back.col(2);
    row.shift = back * shift;
    return row;
}

RowProjection SurfaceProjection::row(float v) const {
    const float part = skewed_ ? v / rows_ - 0.5f : 0;
    const Eigen::Matrix3f A = turn_ + part * turn_skew_;
    return {A.col(0), A.col(1) * v + A.col(2), shift_};
}

} // namespace afterglow
