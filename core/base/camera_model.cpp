// SPDX-License-Identifier: Apache-2.0
#include "core/base/camera_model.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Rays further off the axis are not looked for: atan(40) is 88.6 degrees.
constexpr double widest_ray = 40;
constexpr int most_iterations = 50;
constexpr double solved = 1e-12;
/// Of the pixel's place at depth 1; a root that misses it by more is none.
constexpr double believed = 1e-7;

/// Where a pinhole camera would see the ray `r` after the lens, and its derivative.
struct Bent {
    Eigen::Vector2d at;
    Eigen::Matrix2d by_ray;
};

Bent brown_conrady(const std::array<double, 8> &k, const Eigen::Vector2d &r) {
    const double x = r.x(), y = r.y(), q = r.squaredNorm();
    const double n = 1 + q * (k[0] + q * (k[1] + q * k[4]));
    const double d = 1 + q * (k[5] + q * (k[6] + q * k[7]));
    const double n_by_q = k[0] + q * (2 * k[1] + q * 3 * k[4]);
    const double d_by_q = k[5] + q * (2 * k[6] + q * 3 * k[7]);
    const double s = n / d, s_by_q = (n_by_q - s * d_by_q) / d;
    Bent b;
    b.at = s * r + Eigen::Vector2d(2 * k[2] * x * y + k[3] * (q + 2 * x * x),
                                   k[2] * (q + 2 * y * y) + 2 * k[3] * x * y);
    b.by_ray = s * Eigen::Matrix2d::Identity() + 2 * s_by_q * r * r.transpose();
    b.by_ray(0, 0) += 2 * k[2] * y + 6 * k[3] * x;
    b.by_ray(0, 1) += 2 * k[2] * x + 2 * k[3] * y;
    b.by_ray(1, 0) += 2 * k[2] * x + 2 * k[3] * y;
    b.by_ray(1, 1) += 6 * k[2] * y + 2 * k[3] * x;
    return b;
}

/// The angle's image, theta (1 + k1 theta^2 + ...), and its derivative.
struct BentAngle {
    double at, by_angle;
};

BentAngle kannala_brandt(const std::array<double, 8> &k, double theta) {
    const double q = theta * theta;
    return {theta * (1 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3])))),
            1 + q * (3 * k[0] + q * (5 * k[1] + q * (7 * k[2] + q * 9 * k[3])))};
}

/// Newton's method from the place itself; a step that makes it worse is halved.
std::optional<Eigen::Vector2d> undo_brown_conrady(const std::array<double, 8> &k,
                                                  const Eigen::Vector2d &place) {
    Eigen::Vector2d r = place;
    Bent b = brown_conrady(k, r);
    double off = (b.at - place).norm();
    for (int i = 0; i < most_iterations && off > solved; ++i) {
        // Beyond where the polynomial turns back there is no picture.
        if (!(b.by_ray.determinant() > 0))
            return std::nullopt;
        Eigen::Vector2d step = b.by_ray.inverse() * (place - b.at);
        double next_off = off;
        Bent next = b;
        for (int halved = 0; halved < 20; ++halved, step /= 2) {
            next = brown_conrady(k, r + step);
            next_off = (next.at - place).norm();
            if (next_off < off)
                break;
        }
        if (!(next_off < off))
            break;
        r += step;
        b = next;
        off = next_off;
    }
    const bool found = off < believed && b.by_ray.determinant() > 0 && r.norm() < widest_ray;
    return found ? std::optional(r) : std::nullopt;
}

std::optional<Eigen::Vector2d> undo_kannala_brandt(const std::array<double, 8> &k,
                                                   const Eigen::Vector2d &place) {
    const double radius = place.norm();
    if (radius < solved)
        return place;
    double theta = 0;
    for (int i = 0; i < most_iterations; ++i) {
        const BentAngle b = kannala_brandt(k, theta);
        if (!(b.by_angle > 0))
            return std::nullopt;
        // From below a bent angle is approached without overshooting far.
        const double step = std::min((radius - b.at) / b.by_angle, 0.3);
        theta += step;
        if (std::abs(step) < solved)
            break;
    }
    const BentAngle b = kannala_brandt(k, theta);
    const bool found = std::abs(b.at - radius) < believed && b.by_angle > 0 && theta > 0 &&
                       theta < std::atan(widest_ray);
    return found ? std::optional<Eigen::Vector2d>(place * (std::tan(theta) / radius))
                 : std::nullopt;
}

} // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d &X) const {
    Eigen::Vector2d place = X.head<2>() / X.z();
    if (lens == Lens::brown_conrady) {
        place = brown_conrady(distortion, place).at;
    } else if (lens == Lens::kannala_brandt) {
        const double r = place.norm();
        if (r > solved)
            place *= afterglow::kannala_brandt(distortion, std::atan(r)).at / r;
    }
    return {pinhole.fx * place.x() + pinhole.cx, pinhole.fy * place.y() + pinhole.cy};
}

std::optional<Eigen::Vector2d> CameraModel::ray(double u, double v) const {
    const Eigen::Vector2d place{(u - pinhole.cx) / pinhole.fx, (v - pinhole.cy) / pinhole.fy};
    switch (lens) {
    case Lens::pinhole:
        return place;
    case Lens::brown_conrady:
        return undo_brown_conrady(distortion, place);
    case Lens::kannala_brandt:
        return undo_kannala_brandt(distortion, place);
    }
    return std::nullopt;
}

} // namespace afterglow
