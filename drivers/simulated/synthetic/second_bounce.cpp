// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/second_bounce.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

/// Where rings end, in widths of the image.
constexpr std::array ring_ends = {0.0, 0.013, 0.03, 0.07, 0.14, 0.28};
constexpr int places_in_ring = 8;
/// Of the angle between light and normal: what is seen flatter is not told apart.
constexpr float least_cosine = 0.1F;

} // namespace

SecondBounce::SecondBounce(const PixelRays &rays, double strength)
    : strength_(static_cast<float>(strength)), solid_angle_(rays.width(), rays.height()),
      points_(rays.width(), rays.height(), Eigen::Vector3f::Zero()),
      factors_(rays.width(), rays.height()) {
    constexpr double pi = std::numbers::pi;
    for (std::size_t ring = 0; ring + 1 < ring_ends.size(); ++ring) {
        const double inner = ring_ends[ring] * rays.width();
        const double outer = ring_ends[ring + 1] * rays.width();
        const double radius = (inner + outer) / 2;
        const double area = pi * (outer * outer - inner * inner);
        for (int i = 0; i < places_in_ring; ++i) {
            const double angle = 2 * pi * (i + 0.4 * static_cast<double>(ring)) / places_in_ring;
            const Place place{static_cast<int>(std::lround(radius * std::cos(angle))),
                              static_cast<int>(std::lround(radius * std::sin(angle))),
                              static_cast<float>(area / places_in_ring)};
            if (place.u != 0 || place.v != 0)
                places_.push_back(place);
        }
    }
    for (int v = 0; v < rays.height(); ++v) {
        for (int u = 0; u < rays.width(); ++u) {
            if (!rays.is_seen(u, v))
                continue;
            const double square = 1 + rays.at(u, v).squaredNorm();
            solid_angle_.row(v)[u] = static_cast<float>(
                std::abs(rays.per_pixel(u, v).determinant()) / (square * std::sqrt(square)));
        }
    }
}

ImageView<const std::complex<float>> SecondBounce::factors(const LensRenderer &renderer,
                                                           LumaView luma) {
    const ImageView<const float> z = renderer.depth();
    for (int v = 0; v < z.height(); ++v) {
        for (int u = 0; u < z.width(); ++u)
            points_.row(v)[u] =
                z.row(v)[u] > 0
                    ? Eigen::Vector3f(z.row(v)[u] *
                                      renderer.rays().at(u, v).homogeneous().cast<float>())
                    : Eigen::Vector3f::Zero();
    }
    for (int v = 0; v < z.height(); ++v) {
        for (int u = 0; u < z.width(); ++u)
            factors_.row(v)[u] = factor_at(u, v, renderer.normals(), luma);
    }
    return factors_;
}

std::complex<float> SecondBounce::factor_at(int u, int v, ImageView<const Eigen::Vector3f> normals,
                                            LumaView luma) const {
    constexpr auto pi = std::numbers::pi_v<float>;
    std::complex<float> factor = 1;
    const Eigen::Vector3f &X = points_.row(v)[u];
    const float range = X.norm();
    if (range <= 0)
        return factor;
    const Eigen::Vector3f &n = normals.row(v)[u];
    const float cosine = std::max(-n.dot(X) / range, least_cosine);
    for (const Place &place : places_) {
        const int y_u = u + place.u, y_v = v + place.v;
        if (!luma.contains(y_u, y_v))
            continue;
        const Eigen::Vector3f &Y = points_.row(y_v)[y_u];
        const Eigen::Vector3f way = Y - X;
        const float received = n.dot(way);
        const float sent = -normals.row(y_v)[y_u].dot(way);
        if (received <= 0 || sent <= 0 || Y.z() <= 0)
            continue;
        const float angle = place.pixels * solid_angle_.row(y_v)[y_u];
        const float range_of_y = Y.norm();
        // No patch is nearer than it is large.
        const float square = std::max(way.squaredNorm(), angle * Y.squaredNorm());
        const float length = std::sqrt(way.squaredNorm());
        const float albedo = static_cast<float>(luma.row(y_v)[y_u]) / 255;
        const float share = strength_ * albedo * angle * (sent / length) * (received / length) *
                            range * range / (pi * square * cosine);
        const float detour = (range_of_y + length - range) / 2;
        factor += std::polar(share, 2 * pi * detour / unambiguous_range);
    }
    return factor;
}

} // namespace afterglow
