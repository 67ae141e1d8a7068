// SPDX-License-Identifier: Apache-2.0
#include "core/paper/pose_solver.hpp"

#include <Eigen/Cholesky>

namespace afterglow {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;

/// Smallest pivot of the normal equations, relative to the largest, that still counts as full
/// rank. Points on a line give rounding noise, 1e-16; the worst usable triangles some 1e-8.
constexpr double min_pivot_ratio = 1e-11;

Eigen::Vector2d residual(const Match &match, const Intrinsics &camera, const Eigen::Vector3d &Y) {
    return {((match.to.x() - camera.cx) * Y.z() - camera.fx * Y.x()) / match.z,
            ((match.to.y() - camera.cy) * Y.z() - camera.fy * Y.y()) / match.z};
}

/// Derivative of the modelled motion (the right-hand sides of Eq. 4 and 5) by (theta k, T), where
/// W X is k x X theta.
Matrix26d jacobian(const Match &match, const Intrinsics &camera, const Eigen::Vector3d &X) {
    const double u = match.to.x() - camera.cx;
    const double v = match.to.y() - camera.cy;
    Matrix26d J;
    J << -u * X.y(), camera.fx * X.z() + u * X.x(), -camera.fx * X.y(), camera.fx, 0, -u,
        -camera.fy * X.z() - v * X.y(), v * X.x(), camera.fy * X.x(), 0, camera.fy, -v;
    return J / match.z;
}

Eigen::Vector3d point(const Match &match, const Intrinsics &camera) {
    return camera.back_project(match.from.x(), match.from.y(), match.z);
}

} // namespace

double squared_residual(const Match &match, const Intrinsics &camera, const Pose &pose) {
    return residual(match, camera, pose * point(match, camera)).squaredNorm();
}

std::optional<Pose> solve_pose(std::span<const Match> matches, const Intrinsics &camera,
                               int iterations) {
    if (matches.size() < 3)
        return std::nullopt;
    Matrix6d H = Matrix6d::Zero();
    for (const Match &match : matches) {
        const Matrix26d J = jacobian(match, camera, point(match, camera));
        H += J.transpose() * J;
    }
    const Eigen::LDLT<Matrix6d> ldlt(H);
    const Vector6d pivots = ldlt.vectorD();
    if (ldlt.info() != Eigen::Success || !(pivots.minCoeff() > min_pivot_ratio * pivots.maxCoeff()))
        return std::nullopt;

    Vector6d motion = Vector6d::Zero(); // theta k, T
    Pose pose;
    for (int iteration = 0; iteration < iterations; ++iteration) {
        Vector6d b = Vector6d::Zero();
        for (const Match &match : matches) {
            const Eigen::Vector3d X = point(match, camera);
            b += jacobian(match, camera, X).transpose() * residual(match, camera, pose * X);
        }
        motion += ldlt.solve(b);
        pose = {rotation(motion.head<3>()), motion.tail<3>()};
    }
    if (!pose.is_finite())
        return std::nullopt;
    for (const Match &match : matches)
        if (!((pose * point(match, camera)).z() > 0))
            return std::nullopt;
    return pose;
}

} // namespace afterglow
