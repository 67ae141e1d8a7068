// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/depth_refinement.hpp"

#include "core/base/gaussian.hpp"
#include "core/calibration/depth_comparison.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

using Vector6 = Eigen::Matrix<float, 6, 1>;
using Matrix6 = Eigen::Matrix<float, 6, 6>;

/// Square of Geman and McClure's width in units of the residuals' own scale.
constexpr float robust_width2 = 6.25f;
/// Neighbouring readings share their errors: so many pixels are as good as one independent reading.
/// What bends whole maps they share almost entirely.
constexpr float independent_px2 = 320;
constexpr double shape_independent_px2 = 32000;
/// More readings than about this many, and closer ones than four pixels, add work and nothing else.
constexpr float enough_readings = 1600;
constexpr int closest_px = 4;
constexpr int least_compared = 100;
/// Limits of the difference of two depths in DepthFit::relative_error: as a share of the depth, and
/// in units of the fit's residual scale. Things that moved, and surfaces that hide something from
/// the other map, differ by more, and are no error of either map.
constexpr float most_relative = 0.2f, most_scales = 12;
/// A step below this, metres and radians, is the last, and changes nothing of how well maps fit.
constexpr float converged_step = 1e-3f;

/// Pixels from one reading that is compared to the next.
int grid_of(const Intrinsics &camera) {
    const auto pixels = static_cast<float>(camera.width) * static_cast<float>(camera.height);
    return std::max(closest_px, static_cast<int>(std::lround(std::sqrt(pixels / enough_readings))));
}

/// Calls `visit` with the readings inside of surfaces, `grid` pixels apart, block by block.
template <class Visit>
void visit_readings(const DepthSurface &from, const Intrinsics &c, int grid, const Visit &visit) {
    constexpr int least_distance = 4;
    const float dx = static_cast<float>(1 / c.fx), dy = static_cast<float>(1 / c.fy);
    const float cx = static_cast<float>(c.cx), cy = static_cast<float>(c.cy);
    ComparedPoints points;
    for (int v = grid; v < c.height - grid; v += grid) {
        const float *z = from.z().row(v);
        const std::uint8_t *distance = from.edge_distance().row(v);
        const float y = (static_cast<float>(v) - cy) * dy;
        for (int u = grid; u < c.width - grid; u += grid) {
            if (z[u] == 0.0f || distance[u] < least_distance)
                continue;
            const auto i = static_cast<std::size_t>(points.count++);
            points.x[i] = (static_cast<float>(u) - cx) * dx;
            points.y[i] = y;
            points.z[i] = z[u];
            if (points.count == ComparedPoints::block) {
                visit(points);
                points.count = 0;
            }
        }
    }
    if (points.count > 0)
        visit(points);
}

/// Normal equations of a fit's step, and how well it fits before.
struct Sums {
    static constexpr int columns = DepthComparisons::motions;

    WeightedProducts products; ///< of the derivatives and, last, the error
    std::array<int, DepthComparisons::bins + 1> histogram{};
    int compared = 0, inliers = 0;

    Matrix6 information() const {
        Matrix6 H;
        for (int i = 0; i < columns; ++i)
            for (int j = i; j < columns; ++j)
                H(i, j) = H(j, i) = static_cast<float>(products(i, j));
        return H;
    }
    Vector6 g() const {
        Vector6 g;
        for (int i = 0; i < columns; ++i)
            g[i] = -static_cast<float>(products(i, columns));
        return g;
    }
    float scale() const {
        int left = compared / 2;
        for (std::size_t i = 0; i < DepthComparisons::bins; ++i) {
            if (left < histogram[i])
                return gaussian::deviation_of_median * DepthComparisons::bin_width *
                       (static_cast<float>(i) + 0.5f);
            left -= histogram[i];
        }
        return gaussian::deviation_of_median * DepthComparisons::bin_width * DepthComparisons::bins;
    }
};

Sums compare_maps(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                  const Pose &pose, int grid, float scale) {
    constexpr std::size_t inlier_bins = 16; // of 4 sigmas
    const ComparisonOptions options{.robust_width2 = robust_width2 * scale * scale};
    Sums sums;
    DepthComparisons block;
    visit_readings(from, camera, grid, [&](const ComparedPoints &points) {
        compare_points(points, to, camera, pose, options, block);
        add_products(block, Sums::columns, sums.products);
        for (const int bin : block.bin)
            ++sums.histogram[static_cast<std::size_t>(bin)];
    });
    for (std::size_t i = 0; i < DepthComparisons::bins; ++i) {
        sums.compared += sums.histogram[i];
        sums.inliers += i < inlier_bins ? sums.histogram[i] : 0;
    }
    return sums;
}

/// DepthFit::relative_error; 0 if too few points can be compared. `scale`: that of the residuals,
/// in sensor sigmas.
float relative_error(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                     const Pose &pose, int grid, float scale) {
    const SensorNoise noise = to.noise();
    const ComparisonOptions options{.robust_width2 = 1};
    DepthComparisons block;
    float sum = 0;
    int compared = 0;
    visit_readings(from, camera, grid, [&](const ComparedPoints &points) {
        compare_points(points, to, camera, pose, options, block);
        for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
            if (block.bin[i] == DepthComparisons::bins)
                continue;
            const float z = points.z[i];
            sum += std::min({std::abs(block.error[i]), most_relative * z,
                             most_scales * scale * noise.sigma(z)}) /
                   z;
            ++compared;
        }
    });
    return compared < least_compared ? 0 : sum / static_cast<float>(compared);
}

} // namespace

DepthFit refine_by_depth(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                         const Pose &start, const Matrix6 &start_information,
                         const DepthRefinementOptions &options) {
    const int grid = grid_of(camera);
    const float independent_readings = static_cast<float>(grid * grid) / independent_px2;
    DepthFit fit;
    fit.pose = start;
    Pose pose = start;
    float scale = 8.0f;
    bool holds = true; // enough points are compared, and no step is too long
    for (int i = 0; i <= options.iterations; ++i) {
        const Sums sums = compare_maps(from, to, camera, pose, grid, scale);
        holds = sums.compared >= least_compared;
        if (!holds)
            break;
        scale = std::clamp(sums.scale(), 1.0f, 16.0f);
        fit.pose = pose;
        fit.residual_scale = scale;
        fit.inlier_share = static_cast<float>(sums.inliers) / static_cast<float>(sums.compared);
        if (i == options.iterations)
            break;
        Matrix6 H = independent_readings * sums.information() + start_information;
        const Vector6 off = log(pose * start.inverse()).cast<float>();
        const Vector6 g = independent_readings * sums.g() - start_information * off;
        H.diagonal() += 1e-5f * H.diagonal() + Vector6::Constant(1e-3f);
        const Vector6 x = H.ldlt().solve(g);
        holds = x.allFinite() && x.tail<3>().norm() <= 0.3f && x.head<3>().norm() <= 0.5f;
        if (!holds)
            break;
        pose = exp(x.cast<double>()) * pose;
        if (x.norm() < converged_step) {
            fit.pose = pose;
            break;
        }
    }
    fit.relative_error = relative_error(from, to, camera, fit.pose, grid, scale);
    fit.good = holds && fit.inlier_share >= options.least_inlier_share;
    return fit;
}

CalibrationEvidence calibration_evidence(const DepthSurface &from, const DepthSurface &to,
                                         const Intrinsics &camera, const DepthFit &fit,
                                         const Pose &start, const Matrix6 &start_information,
                                         const Eigen::Vector3d &rate_change, double lag_s) {
    using Matrix10 = Eigen::Matrix<double, 10, 10>;
    using Vector10 = Eigen::Matrix<double, 10, 1>;
    using Matrix6x10 = Eigen::Matrix<double, 6, 10>;
    constexpr int columns = DepthComparisons::motions + DepthComparisons::shapes;
    const int grid = grid_of(camera);
    WeightedProducts products;
    const ComparisonOptions options{.robust_width2 =
                                        robust_width2 * fit.residual_scale * fit.residual_scale,
                                    .with_shape = true,
                                    .from_shape = from.correction().shape};
    DepthComparisons block;
    visit_readings(from, camera, grid, [&](const ComparedPoints &points) {
        compare_points(points, to, camera, fit.pose, options, block);
        add_products(block, columns, products);
    });
    Matrix10 H = Matrix10::Zero(); // unknowns: motion after the fit (6), shape (3), lag (1)
    Vector10 g = Vector10::Zero();
    const double share = static_cast<double>(grid * grid) / shape_independent_px2;
    for (int i = 0; i < columns; ++i) {
        for (int j = i; j < columns; ++j)
            H(i, j) = H(j, i) = share * products(i, j);
        g[i] = -share * products(i, columns);
    }
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
