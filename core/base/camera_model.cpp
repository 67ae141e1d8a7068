// SPDX-License-Identifier: Apache-2.0
#include "core/base/camera_model.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

/// Rays further off the axis are given by no lens: atan(40) is 88.6 degrees.
constexpr double widest_ray = 40;
constexpr int most_iterations = 50;
constexpr double solved = 1e-12;
/// Of the pixel's place at depth 1; a root that misses it by more is none.
constexpr double believed = 1e-7;
constexpr double longest_step = 0.3;
constexpr int most_halved = 20;
constexpr double sampled = 0.05;

/// Where a bent ray or angle gets to, and its derivative by what it was.
template <int size>
struct Bent {
    Eigen::Matrix<double, size, 1> at;
    Eigen::Matrix<double, size, size> slope;

    /// Near here the lens keeps the order of what it bends.
    bool rises() const { return slope.determinant() > 0; }
};

/// Where a pinhole camera would see the ray `r` after the lens.
Bent<2> brown_conrady(const std::array<double, 8> &k, const Eigen::Vector2d &r) {
    const double x = r.x(), y = r.y(), q = r.squaredNorm();
    const double n = 1 + q * (k[0] + q * (k[1] + q * k[4]));
    const double d = 1 + q * (k[5] + q * (k[6] + q * k[7]));
    const double n_by_q = k[0] + q * (2 * k[1] + q * 3 * k[4]);
    const double d_by_q = k[5] + q * (2 * k[6] + q * 3 * k[7]);
    const double s = n / d, s_by_q = (n_by_q - s * d_by_q) / d;
    Bent<2> b;
    b.at = s * r + Eigen::Vector2d(2 * k[2] * x * y + k[3] * (q + 2 * x * x),
                                   k[2] * (q + 2 * y * y) + 2 * k[3] * x * y);
    b.slope = s * Eigen::Matrix2d::Identity() + 2 * s_by_q * r * r.transpose();
    b.slope(0, 0) += 2 * k[2] * y + 6 * k[3] * x;
    b.slope(0, 1) += 2 * k[2] * x + 2 * k[3] * y;
    b.slope(1, 0) += 2 * k[2] * x + 2 * k[3] * y;
    b.slope(1, 1) += 6 * k[2] * y + 2 * k[3] * x;
    if (!(d > 0)) // beyond a pole
        b.slope.setZero();
    return b;
}

/// theta (1 + k1 theta^2 + ...)
Bent<1> kannala_brandt(const std::array<double, 8> &k, double theta) {
    const double q = theta * theta;
    Bent<1> b;
    b.at << theta * (1 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3]))));
    b.slope << 1 + q * (3 * k[0] + q * (5 * k[1] + q * (7 * k[2] + q * 9 * k[3])));
    return b;
}

/// Looks at a few places on the way, so that a step does not cross where the lens turns back.
template <class Bend, class Place>
bool rises_between(const Bend &bend, const Place &from, const Place &step) {
    const int parts = static_cast<int>(step.norm() / sampled) + 1;
    for (int i = 1; i < parts; ++i)
        if (!bend(from + step * i / parts).rises())
            return false;
    return true;
}

/// What `bend` takes to `place`, by Newton's method from the axis; a step is cut where it is long,
/// makes it worse or leaves the rise. After a lens has turned back once there is no picture, even
/// where it rises again.
template <class Bend, class Place>
std::optional<Place> undo(const Bend &bend, const Place &place) {
    Place r = Place::Zero();
    auto b = bend(r);
    double off = place.norm();
    for (int i = 0; i < most_iterations && off > solved; ++i) {
        Place step = b.slope.inverse() * (place - b.at);
        step *= std::min(1.0, longest_step * (1 + r.norm()) / step.norm());
        bool nearer = false;
        for (int halved = 0; halved < most_halved && !nearer; ++halved, step /= 2) {
            const auto next = bend(r + step);
            const double next_off = (next.at - place).norm();
            nearer = next_off < off && next.rises() && rises_between(bend, r, step);
            if (nearer) {
                r += step;
                b = next;
                off = next_off;
            }
        }
        if (!nearer)
            break;
    }
    return off < believed ? std::optional(r) : std::nullopt;
}

} // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d &X) const {
    Eigen::Vector2d place = X.head<2>() / X.z();
    if (lens == Lens::brown_conrady) {
        place = brown_conrady(distortion, place).at;
    } else if (lens == Lens::kannala_brandt) {
        const double r = place.norm();
        if (r > solved)
            place *= kannala_brandt(distortion, std::atan(r)).at.value() / r;
    }
    return {pinhole.fx * place.x() + pinhole.cx, pinhole.fy * place.y() + pinhole.cy};
}

std::optional<Eigen::Vector2d> CameraModel::ray(double u, double v) const {
    Eigen::Vector2d place{(u - pinhole.cx) / pinhole.fx, (v - pinhole.cy) / pinhole.fy};
    std::optional<Eigen::Vector2d> ray = place;
    if (lens == Lens::brown_conrady) {
        ray =
            undo([this](const Eigen::Vector2d &r) { return brown_conrady(distortion, r); }, place);
    } else if (lens == Lens::kannala_brandt) {
        using Angle = Eigen::Matrix<double, 1, 1>;
        const double radius = place.norm();
        const auto theta =
            undo([this](const Angle &a) { return kannala_brandt(distortion, a.value()); },
                 Angle(radius));
        if (radius > solved)
            ray = theta && theta->value() < std::numbers::pi / 2
                      ? std::optional<Eigen::Vector2d>(place * (std::tan(theta->value()) / radius))
                      : std::nullopt;
    }
    return ray && ray->norm() < widest_ray ? ray : std::nullopt;
}

} // namespace afterglow
