// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/depth_edges.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace afterglow {
namespace {

/// A step of less than this share of the depth may be a slope.
constexpr float least_step = 0.05f;
constexpr int window = 3; ///< half the side of what tells an edge's direction, pixels
constexpr int shadow = 5; ///< the further surface may begin so many pixels away (sensor holes)
constexpr int border = window + 2;
/// Of the window: less is a spike and not a surface, or an edge without direction.
constexpr int least_own = 12;
constexpr float least_direction = 4;
constexpr float half_pixel = 0.5f;
constexpr float beyond_px = 3;

struct Offset {
    int u, v;
};

/// The pixels of a 4 x 4 cell, such that each four in turn have one in each row and column: upright
/// and level edges are met as often as others.
constexpr std::array<Offset, 16> scattered = {{{0, 0},
                                               {1, 2},
                                               {2, 1},
                                               {3, 3},
                                               {2, 0},
                                               {3, 2},
                                               {0, 1},
                                               {1, 3},
                                               {1, 0},
                                               {2, 2},
                                               {3, 1},
                                               {0, 3},
                                               {3, 0},
                                               {0, 2},
                                               {1, 1},
                                               {2, 3}}};
constexpr int cell = 4;
/// Edges that one pass over the map may find, for each that is kept.
constexpr std::size_t room = 16;

/// The next reading from (u, v) on in a direction is further by `step`.
bool ends_towards(ImageView<const float> z, int u, int v, Offset direction, float step) {
    for (int k = 1; k <= shadow; ++k) {
        const int x = u + k * direction.u, y = v + k * direction.v;
        if (!z.contains(x, y))
            return false;
        if (z(x, y) != 0.0f)
            return z(x, y) - z(u, v) > step;
    }
    return false;
}

/// Unit vector from the near surface at (u, v) to what lies behind it, if the surface ends there.
std::optional<Eigen::Vector2f> outward(ImageView<const float> z, int u, int v, float step) {
    constexpr std::array<Offset, 4> neighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    if (std::ranges::none_of(neighbours, [&](Offset d) { return ends_towards(z, u, v, d, step); }))
        return std::nullopt;
    const float near = z(u, v);
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int own = 0;
    for (int y = -window; y <= window; ++y)
        for (int x = -window; x <= window; ++x) {
            const float other = z(u + x, v + y);
            if (other != 0.0f && near - other > step)
                return std::nullopt; // something nearer ends here, too
            if (x == 0 && y == 0)
                continue;
            if (other == 0.0f || other - near > step)
                sum += (other == 0.0f ? 0.5f : 1.0f) * Eigen::Vector2f(x, y).normalized();
            else
                ++own;
        }
    const float length = sum.norm();
    if (own < least_own || length < least_direction)
        return std::nullopt;
    return sum / length;
}

} // namespace

DepthEdges::DepthEdges(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {
    edges_.reserve(room * capacity_);
}

std::span<const DepthEdge> DepthEdges::find(const DepthSurface &surface, const Intrinsics &camera,
                                            const Pose &pose) {
    const ImageView<const float> z = surface.z();
    const ImageView<const std::uint8_t> distance = surface.edge_distance();
    edges_.clear();
    for (std::size_t pass = 0; pass < scattered.size(); ++pass) {
        if (pass % cell == 0 && edges_.size() >= capacity_)
            break;
        const Offset first = scattered[pass];
        for (int v = border + first.v; v < z.height() - border; v += cell)
            for (int u = border + first.u; u < z.width() - border; u += cell) {
                const float near = z(u, v);
                if (near == 0.0f || distance(u, v) != 1 || edges_.size() == edges_.capacity())
                    continue;
                const float step = std::max(surface.edge_step(near), least_step * near);
                const std::optional<Eigen::Vector2f> n = outward(z, u, v, step);
                if (!n)
                    continue;
                const auto point = [&](float px) -> Eigen::Vector3f {
                    return (pose * camera.back_project(static_cast<float>(u) + px * n->x(),
                                                       static_cast<float>(v) + px * n->y(), near))
                        .cast<float>();
                };
                edges_.push_back({point(half_pixel), point(half_pixel + beyond_px)});
            }
    }
    // Too many are thinned, not cut off.
    const std::size_t found = edges_.size(), kept = std::min(found, capacity_);
    for (std::size_t i = 0; i < kept; ++i)
        edges_[i] = edges_[i * found / kept];
    return std::span(edges_).first(kept);
}

} // namespace afterglow
