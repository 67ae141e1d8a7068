// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_refinement.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

using Vector6 = Eigen::Matrix<float, 6, 1>;
using Matrix6 = Eigen::Matrix<float, 6, 6>;

constexpr int error_bins = 64;
constexpr float error_bin_width = 0.25f;
/// Square of Geman and McClure's width in units of the residuals' own scale.
constexpr float robust_width2 = 6.25f;
/// Neighbouring readings share their errors: each counts for a part of one. What bends whole maps
/// they share almost entirely.
constexpr float independent_readings = 0.05f;
constexpr double shape_independent_share = 0.0005;

struct Sums {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    std::array<int, error_bins> histogram{};
    int sampled = 0, compared = 0, inliers = 0;

    float scale() const {
        int left = compared / 2;
        for (std::size_t i = 0; i < error_bins; ++i) {
            if (left < histogram[i])
                return 1.4826f * error_bin_width * (static_cast<float>(i) + 0.5f);
            left -= histogram[i];
        }
        return 1.4826f * error_bin_width * error_bins;
    }
};

/// One reading of the first map compared with the second.
struct Comparison {
    float error; ///< metres: second map's depth less the first's, carried along the pose
    float sigma; ///< of the sensor
    Vector6 J;   ///< of the error by the motion applied after the pose: X' -> X' + v + w x X'
    Eigen::Vector3f by_shape_from, by_shape_to; ///< of the error by either map's shape
};

/// Calls `visit` for each reading, grid_px apart, that both maps have inside a surface.
template <class Visit>
int compare_maps(const DepthSurface &from, const DepthSurface &to, const Intrinsics &c,
                 const Pose &pose, int grid, const Visit &visit) {
    const Eigen::Matrix3f R = pose.R.cast<float>();
    const Eigen::Vector3f T = pose.T.cast<float>();
    const float fx = static_cast<float>(c.fx), fy = static_cast<float>(c.fy);
    const float cx = static_cast<float>(c.cx), cy = static_cast<float>(c.cy);
    const int w = c.width, h = c.height;
    int sampled = 0;
    for (int v = grid; v < h - grid; v += grid)
        for (int u = grid; u < w - grid; u += grid) {
            const float z = from.z()(u, v);
            if (z == 0.0f || from.edge_distance()(u, v) < 4)
                continue;
            ++sampled;
            const float x = (static_cast<float>(u) - cx) / fx;
            const float y = (static_cast<float>(v) - cy) / fy;
            const Eigen::Vector3f X{x * z, y * z, z};
            const Eigen::Vector3f RX = R * X;
            const Eigen::Vector3f Y = RX + T;
            if (!(Y.z() > 0.1f))
                continue;
            const float inv = 1.0f / Y.z();
            const float pu = fx * Y.x() * inv + cx, pv = fy * Y.y() * inv + cy;
            if (!(pu >= 3.0f && pv >= 3.0f && pu < static_cast<float>(w - 4) &&
                  pv < static_cast<float>(h - 4)))
                continue;
            const int iu = static_cast<int>(pu + 0.5f), iv = static_cast<int>(pv + 0.5f);
            if (to.edge_distance()(iu, iv) < 4)
                continue;
            const float d = to.z()(iu, iv);
            const float l = to.z()(iu - 3, iv), r = to.z()(iu + 3, iv);
            const float t = to.z()(iu, iv - 3), b = to.z()(iu, iv + 3);
            if (d == 0.0f || l == 0.0f || r == 0.0f || t == 0.0f || b == 0.0f)
                continue;
            const float du = (r - l) * (1.0f / 6.0f), dv = (b - t) * (1.0f / 6.0f);
            Comparison compared;
            compared.error =
                d + du * (pu - static_cast<float>(iu)) + dv * (pv - static_cast<float>(iv)) - Y.z();
            compared.sigma = to.noise().sigma(d);
            // The sampled depth changes as the point moves across the map.
            const float a = du * fx * inv, q = dv * fy * inv;
            const Eigen::Vector3f by_Y{a, q, -(a * Y.x() + q * Y.y()) * inv - 1.0f};
            compared.J.head<3>() = by_Y;
            compared.J.tail<3>() = Y.cross(by_Y);
            compared.by_shape_from = by_Y.dot(RX) * DepthCorrection::basis(x, y);
            compared.by_shape_to = d * DepthCorrection::basis(Y.x() * inv, Y.y() * inv);
            visit(compared);
        }
    return sampled;
}

void accumulate(const DepthSurface &from, const DepthSurface &to, const Intrinsics &c,
                const Pose &pose, int grid, float scale, Sums &sums) {
    const float width2 = robust_width2 * scale * scale;
    sums.sampled = compare_maps(from, to, c, pose, grid, [&](const Comparison &p) {
        const float n = std::abs(p.error) / p.sigma;
        ++sums.compared;
        sums.inliers += n < 4.0f;
        ++sums.histogram[static_cast<std::size_t>(
            std::min(static_cast<int>(std::min(n, 1000.0f) / error_bin_width), error_bins - 1))];
        const float robust = width2 / (n * n + width2);
        const float weight = robust * robust / (p.sigma * p.sigma);
        sums.H.noalias() += weight * p.J * p.J.transpose();
        sums.g.noalias() -= weight * p.error * p.J;
    });
}

} // namespace

DepthFit refine_by_depth(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                         const Pose &start, const Matrix6 &start_information,
                         const DepthRefinementOptions &options) {
    DepthFit fit;
    fit.pose = start;
    Pose pose = start;
    float scale = 8.0f;
    for (int i = 0; i <= options.iterations; ++i) {
        Sums sums;
        accumulate(from, to, camera, pose, options.grid_px, scale, sums);
        if (sums.compared < 100)
            return fit;
        scale = std::clamp(sums.scale(), 1.0f, 16.0f);
        fit.pose = pose;
        fit.residual_scale = scale;
        fit.inlier_share = static_cast<float>(sums.inliers) / static_cast<float>(sums.compared);
        fit.compared_share = static_cast<float>(sums.compared) / static_cast<float>(sums.sampled);
        if (i == options.iterations)
            break;
        Matrix6 H = independent_readings * sums.H + start_information;
        const Vector6 off = log(pose * start.inverse()).cast<float>();
        const Vector6 g = independent_readings * sums.g - start_information * off;
        H.diagonal() += 1e-5f * H.diagonal() + Vector6::Constant(1e-3f);
        const Vector6 x = H.ldlt().solve(g);
        if (!x.allFinite() || x.tail<3>().norm() > 0.3f || x.head<3>().norm() > 0.5f)
            return fit;
        pose = exp(x.cast<double>()) * pose;
        if (x.norm() < 1e-5f)
            i = std::max(i, options.iterations - 1);
    }
    fit.good = fit.inlier_share >= options.least_inlier_share;
    return fit;
}

CalibrationEvidence calibration_evidence(const DepthSurface &from, const DepthSurface &to,
                                         const Intrinsics &camera, const DepthFit &fit,
                                         const Pose &start, const Matrix6 &start_information,
                                         const Eigen::Vector3d &rate_change, double lag_s) {
    using Vector9 = Eigen::Matrix<double, 9, 1>;
    using Matrix10 = Eigen::Matrix<double, 10, 10>;
    using Vector10 = Eigen::Matrix<double, 10, 1>;
    using Matrix6x10 = Eigen::Matrix<double, 6, 10>;
    Matrix10 H = Matrix10::Zero(); // unknowns: motion after the fit (6), shape (3), lag (1)
    Vector10 g = Vector10::Zero();
    const float width2 = robust_width2 * fit.residual_scale * fit.residual_scale;
    const Eigen::Vector3f &shape_from = from.correction().shape;
    const Eigen::Vector3f &shape_to = to.correction().shape;
    compare_maps(
        from, to, camera, fit.pose, DepthRefinementOptions{}.grid_px, [&](const Comparison &p) {
            const float n = p.error / p.sigma;
            const float robust = width2 / (n * n + width2);
            const double weight = shape_independent_share * robust * robust / (p.sigma * p.sigma);
            // As it would be, had the maps been taken as they came.
            const double error =
                p.error - p.by_shape_from.dot(shape_from) - p.by_shape_to.dot(shape_to);
            Vector9 J;
            J << p.J.cast<double>(), (p.by_shape_from + p.by_shape_to).cast<double>();
            H.topLeftCorner<9, 9>().noalias() += weight * J * J.transpose();
            g.head<9>().noalias() -= weight * error * J;
        });
    // What the images told of the pose: where they put it moves with the lag.
    Matrix6x10 P = Matrix6x10::Zero();
    P.leftCols<6>().setIdentity();
    P.col(9).tail<3>() = -rate_change;
    Twist off = log(fit.pose * start.inverse()).cast<float>().cast<double>();
    off.tail<3>() += lag_s * rate_change;
    const Eigen::Matrix<double, 6, 6> information = start_information.cast<double>();
    H += P.transpose() * information * P;
    g -= P.transpose() * information * off;
    // The pose is eliminated (Schur complement).
    const Eigen::Matrix<double, 6, 4> cross = H.topRightCorner<6, 4>();
    const auto pose_part = H.topLeftCorner<6, 6>().ldlt();
    CalibrationEvidence evidence;
    evidence.H = H.bottomRightCorner<4, 4>() - cross.transpose() * pose_part.solve(cross);
    evidence.g = g.tail<4>() - cross.transpose() * pose_part.solve(g.head<6>());
    return evidence;
}

} // namespace afterglow
