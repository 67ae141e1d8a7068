// SPDX-License-Identifier: Apache-2.0
#include "core/error/expected_error.hpp"

#include "core/base/gaussian.hpp"
#include "core/surface/sampled_readings.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Probability that a Gaussian exceeds x standard deviations.
float upper_tail(float x) {
    return 0.5f * std::erfc(x * 0.70710678f);
}

/// As std::hypot(), to the bit in glibc, without a call.
float hypotenuse(float a, float b) {
    return static_cast<float>(std::sqrt(double{a} * a + double{b} * b));
}

/// Variance of g . (v + w x X) for a motion (v, w) of covariance C.
double variance_along(const Eigen::Vector3d &g, const Eigen::Vector3d &X,
                      const Eigen::Matrix<double, 6, 6> &C) {
    Eigen::Matrix<double, 6, 1> a;
    a << g, X.cross(g);
    return a.dot(C * a);
}

/// Mean relative difference of the depths that are so many pixels apart, across or down the map,
/// whichever is more. No pair counts for more than its whole depth.
float difference_at(ImageView<const float> z, int distance) {
    constexpr int grid = 8;
    if (distance == 0)
        return 0;
    const auto along = [&](int du, int dv) {
        double sum = 0;
        int count = 0;
        for (int v = grid / 2; v + dv < z.height(); v += grid)
            for (int u = grid / 2; u + du < z.width(); u += grid) {
                const float a = z(u, v), b = z(u + du, v + dv);
                if (a == 0.0f || b == 0.0f)
                    continue;
                sum += std::min(2 * std::abs(a - b) / (a + b), 1.0f);
                ++count;
            }
        return count > 0 ? static_cast<float>(sum / count) : 0.0f;
    };
    return std::max(along(distance, 0), along(0, distance));
}

/// Of a pixel so far from a depth edge that is displaced with so much deviation, pixels.
float edge_error(const DepthSurface &surface, std::size_t distance, float deviation) {
    return surface.edge_jump() * upper_tail((static_cast<float>(distance) - 0.5f) / deviation);
}

} // namespace

Eigen::Matrix<float, 6, 6> lag_covariance(const Twist &then, const Twist &now, const Pose &pose,
                                          float lag_jitter_s) {
    const Twist before = adjoint(pose.inverse()) * now;
    return lag_jitter_s * lag_jitter_s *
           (then * then.transpose() + before * before.transpose()).cast<float>();
}

MapError fresh_map_error(const DepthSurface &surface, const Intrinsics &camera,
                         const ErrorOptions &options, float calibration_shift) {
    MapError e;
    e.slope = surface.slope();
    e.misplaced = difference_at(
        surface.z(),
        static_cast<int>(std::lround(calibration_shift * static_cast<float>(camera.fx))));
    for (std::size_t d = 1; d < e.edge.size(); ++d)
        e.edge[d] = e.fresh_edge[d] = edge_error(surface, d, options.edge_registration_px);
    return e;
}

MapError map_error(const DepthSurface &surface, const Views &views, const Pose &pose,
                   const Eigen::Matrix<float, 6, 6> &covariance, const ErrorOptions &options,
                   float calibration_shift) {
    constexpr int reach = 4;
    const Intrinsics &camera = views.surface, &to = views.published;
    const ImageView<const float> depth = surface.z();
    const double fx = camera.fx, fy = camera.fy;
    const Eigen::Matrix<double, 6, 6> A = adjoint(views.surface_from_tracking);
    const Eigen::Matrix<double, 6, 6> C = A * covariance.cast<double>() * A.transpose();
    double depth_variance = 0;
    double shift_variance = 0;
    int seen = 0;
    for_sampled_readings(surface, [&](int u, int v, float z) {
        const Eigen::Vector3d X = camera.back_project(u, v, z);
        const Eigen::Vector3d Y = pose * X;
        if (!(Y.z() > nearest_seen_m))
            return;
        const Eigen::Vector2d p = to.project(Y);
        if (!(p.x() >= 0 && p.y() >= 0 && p.x() < to.width && p.y() < to.height))
            return;
        ++seen;
        // Inverse depth is linear in the image on a plane: its gradient is the normal.
        Eigen::Vector3d n{0, 0, 1.0 / z};
        const bool inside =
            u >= reach && v >= reach && u < depth.width() - reach && v < depth.height() - reach;
        if (inside && surface.edge_distance()(u, v) > reach) {
            const double l = depth(u - reach, v), r = depth(u + reach, v);
            const double t = depth(u, v - reach), b = depth(u, v + reach);
            if (l > 0 && r > 0 && t > 0 && b > 0) {
                const double qu = (1 / r - 1 / l) / (2.0 * reach);
                const double qv = (1 / b - 1 / t) / (2.0 * reach);
                n = {qu * fx, qv * fy, 1.0 / z - (qu * fx * X.x() + qv * fy * X.y()) / z};
            }
        }
        depth_variance += std::min(variance_along(n, X, C), 1.0);
        const Eigen::Vector3d du{to.fx / z, 0, -to.fx * X.x() / (z * z)};
        const Eigen::Vector3d dv{0, to.fy / z, -to.fy * X.y() / (z * z)};
        shift_variance += std::min(variance_along(du, X, C) + variance_along(dv, X, C), 1e4);
    });
    if (seen == 0) { // what little may be seen is not known: wrong by its whole depth
        depth_variance = 1;
        shift_variance = 1e4;
        seen = 1;
    }
    MapError e = fresh_map_error(surface, camera, options, calibration_shift);
    e.pose_relative = static_cast<float>(std::sqrt(std::max(0.0, depth_variance / seen)));
    e.shift_px = static_cast<float>(std::sqrt(std::max(0.0, shift_variance / seen)));
    const float spread = hypotenuse(options.edge_registration_px, e.shift_px);
    for (std::size_t d = 1; d < e.edge.size(); ++d)
        e.edge[d] = edge_error(surface, d, spread);
    return e;
}

float uncorrelated_share(float displacement) {
    // The uncorrelated share of the variance between maps of one view, and the displacement,
    // radians, at which half of the rest is uncorrelated, too.
    constexpr float of_one_view = 0.4f, half = 0.02f;
    return std::sqrt(of_one_view + (1 - of_one_view) * displacement / (displacement + half));
}

float PixelError::scaled(const ErrorScales &scales) const {
    return std::sqrt(scales.fresh * scales.fresh * fresh * fresh +
                     scales.carried * scales.carried * carried2);
}

PixelError pixel_error(const MapError &map, const SensorNoise &noise, float shared_noise, float z,
                       int edge_distance) {
    // Both the carried reading and the fresh one it is compared with are noisy.
    const float sensor = noise.sigma(z) / z * std::sqrt(1.0f + shared_noise * shared_noise);
    const auto d = static_cast<std::size_t>(edge_distance & 7);
    const float fresh = gaussian::mean_absolute * sensor + map.fresh_edge[d];
    const float whole = gaussian::mean_absolute *
                            (hypotenuse(sensor, map.pose_relative) + map.slope * map.shift_px) +
                        map.edge[d];
    return {.fresh = fresh, .carried2 = std::max(whole * whole - fresh * fresh, 0.0f)};
}

} // namespace afterglow
