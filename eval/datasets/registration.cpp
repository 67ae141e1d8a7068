// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/registration.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Pixels. No depth camera is so coarse: larger triangles come from points that lie nearly in the
/// colour camera's own plane, and would take for ever.
constexpr double max_triangle_side = 32;

/// A measured point in the colour image.
struct Corner {
    double u = 0;
    double v = 0;
    double inverse_z = 0; ///< 1 / metres; 0 = nothing measured
};

/// Keeps the nearest: `nearest` holds 1 / z, 0 where nothing was drawn.
void draw(Image<float> &nearest, int u, int v, double inverse_z) {
    nearest(u, v) = std::max(nearest(u, v), static_cast<float>(inverse_z));
}

void draw_point(Image<float> &nearest, const Corner &a) {
    const double u = std::round(a.u), v = std::round(a.v);
    if (a.inverse_z > 0 && u >= 0 && v >= 0 && u < nearest.width() && v < nearest.height())
        draw(nearest, static_cast<int>(u), static_cast<int>(v), a.inverse_z);
}

bool on_one_surface(const Corner &a, const Corner &b, const Corner &c) {
    const auto [far, near] = std::minmax({a.inverse_z, b.inverse_z, c.inverse_z});
    return far > 0 && near <= far * (1 + double(DepthRegistration::surface_step));
}

/// Twice the area of the triangle a b (u, v); positive when they turn right, as a surface seen
/// from its front does.
double turn(const Corner &a, const Corner &b, double u, double v) {
    return (b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u);
}

void draw_triangle(Image<float> &nearest, const Corner &a, const Corner &b, const Corner &c) {
    const double area = turn(a, b, c.u, c.v);
    if (!on_one_surface(a, b, c) || area <= 0)
        return;
    const auto [left, right] = std::minmax({a.u, b.u, c.u});
    const auto [top, bottom] = std::minmax({a.v, b.v, c.v});
    if (right - left > max_triangle_side || bottom - top > max_triangle_side)
        return;
    const int u_end = static_cast<int>(std::clamp(right + 1, 0.0, double(nearest.width())));
    const int v_end = static_cast<int>(std::clamp(bottom + 1, 0.0, double(nearest.height())));
    // Pixels on an edge belong to both triangles that share it, whatever the rounding.
    const double slack = -1e-9 * (1 + area);
    for (int v = static_cast<int>(std::max(std::ceil(top), 0.0)); v < v_end; ++v) {
        for (int u = static_cast<int>(std::max(std::ceil(left), 0.0)); u < u_end; ++u) {
            const double of_a = turn(b, c, u, v);
            const double of_b = turn(c, a, u, v);
            const double of_c = turn(a, b, u, v);
            if (of_a >= slack && of_b >= slack && of_c >= slack)
                draw(nearest, u, v,
                     (of_a * a.inverse_z + of_b * b.inverse_z + of_c * c.inverse_z) / area);
        }
    }
}

/// Draws the surface between four neighbouring points: two triangles along the diagonal over which
/// depth changes less, or one where a corner is missing.
void draw_quad(Image<float> &nearest, const Corner &a, const Corner &b, const Corner &c,
               const Corner &d) {
    if (std::abs(a.inverse_z - d.inverse_z) <= std::abs(b.inverse_z - c.inverse_z)) {
        draw_triangle(nearest, a, b, d);
        draw_triangle(nearest, a, d, c);
    } else {
        draw_triangle(nearest, a, b, c);
        draw_triangle(nearest, b, d, c);
    }
}

} // namespace

DepthRegistration::DepthRegistration(const Intrinsics &depth, const LensDistortion &depth_lens,
                                     const Pose &depth_to_color, const Intrinsics &color)
    : depth_(depth), color_(color), translation_(depth_to_color.T) {
    rays_.reserve(static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
    for (int v = 0; v < depth.height; ++v) {
        for (int u = 0; u < depth.width; ++u) {
            const Eigen::Vector2d x =
                depth_lens.undistort({(u - depth.cx) / depth.fx, (v - depth.cy) / depth.fy});
            rays_.push_back(depth_to_color.R * Eigen::Vector3d(x.x(), x.y(), 1));
        }
    }
}

DepthMap DepthRegistration::registered(ImageView<const float> metres) const {
    assert(metres.width() == depth_.width && metres.height() == depth_.height);
    Image<Corner> corners(depth_.width, depth_.height);
    for (int v = 0; v < metres.height(); ++v) {
        for (int u = 0; u < metres.width(); ++u) {
            if (!(metres(u, v) > 0))
                continue;
            const std::size_t at =
                static_cast<std::size_t>(v) * static_cast<std::size_t>(depth_.width) +
                static_cast<std::size_t>(u);
            const Eigen::Vector3d X = metres(u, v) * rays_[at] + translation_;
            if (X.z() <= 0)
                continue;
            const Eigen::Vector2d pixel = color_.project(X);
            corners(u, v) = {pixel.x(), pixel.y(), 1 / X.z()};
        }
    }

    Image<float> surfaces(color_.width, color_.height);
    Image<float> points(color_.width, color_.height);
    for (int v = 0; v < corners.height(); ++v) {
        for (int u = 0; u < corners.width(); ++u) {
            draw_point(points, corners(u, v));
            if (u + 1 < corners.width() && v + 1 < corners.height())
                draw_quad(surfaces, corners(u, v), corners(u + 1, v), corners(u, v + 1),
                          corners(u + 1, v + 1));
        }
    }

    DepthMap depth(color_.width, color_.height);
    for (int v = 0; v < depth.height(); ++v) {
        for (int u = 0; u < depth.width(); ++u) {
            // A point is half a pixel off, so a surface's own depth is better, unless the point is
            // of something in front of it.
            const float surface = surfaces(u, v), point = points(u, v);
            const float inverse_z = point > surface * (1 + surface_step) ? point : surface;
            const double mm = inverse_z > 0 ? 1000 / double(inverse_z) + 0.5 : 0;
            depth(u, v) = mm < 65536 ? static_cast<std::uint16_t>(mm) : std::uint16_t{0};
        }
    }
    return depth;
}

} // namespace afterglow
