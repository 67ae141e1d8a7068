// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/lens_renderer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>

namespace afterglow {
namespace {

constexpr int tile_width = 32;
/// Of 1080 rows that are read in 30 ms these are taken within 0.1 ms.
constexpr int tile_height = 4;

/// Rays are its pixels.
constexpr Intrinsics unit_camera{.fx = 1, .fy = 1};

} // namespace

LensRenderer::LensRenderer(const Scene &scene, const CameraModel &camera, Extra extra)
    : surfaces_(scene), rays_(camera), z_(rays_.width(), rays_.height()) {
    if (extra == Extra::normals)
        normals_ = Image<Eigen::Vector3f>(rays_.width(), rays_.height(), Eigen::Vector3f::Zero());
    candidates_.reserve(scene.quads.size() + scene.spheres.size());
    for (int v = 0; v < rays_.height(); v += tile_height) {
        for (int u = 0; u < rays_.width(); u += tile_width) {
            Tile tile{.u = u,
                      .v = v,
                      .width = std::min(tile_width, rays_.width() - u),
                      .height = std::min(tile_height, rays_.height() - v),
                      .box = {},
                      .whole = true};
            Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
            Eigen::Vector2d high = -low;
            for (int y = v; y < v + tile.height; ++y) {
                for (int x = u; x < u + tile.width; ++x) {
                    if (!rays_.is_seen(x, y)) {
                        tile.whole = false;
                        continue;
                    }
                    const Eigen::Vector2d margin = rays_.per_pixel(x, y).cwiseAbs().rowwise().sum();
                    low = low.cwiseMin(rays_.at(x, y) - margin);
                    high = high.cwiseMax(rays_.at(x, y) + margin);
                }
            }
            if (low.x() <= high.x())
                tile.box = {(low.x() + high.x()) / 2, (low.y() + high.y()) / 2,
                            (high.x() - low.x()) / 2, (high.y() - low.y()) / 2};
            tiles_.push_back(tile);
        }
    }
}

void LensRenderer::render(const Shot &shot, ImageView<std::uint8_t> luma) {
    assert(luma.empty() || luma.same_size(z_.view()));
    int placed = -1; // rows for which the surfaces are where they should be
    for (const Tile &tile : tiles_) {
        if (placed < 0 || (shot.readout_s != 0 && placed != tile.v)) {
            const double row = tile.v + (tile.height - 1) / 2.0;
            const double t_s = shot.t_s + shot.readout_s * (row / rays_.height() - 0.5);
            surfaces_.place(t_s, shot.camera_from_body * shot.body(t_s).inverse(), unit_camera);
            placed = tile.v;
        }
        find_candidates(tile.box);
        const PlaneView *only =
            candidates_.size() == 1 ? surfaces_.plane(candidates_[0].surface) : nullptr;
        if (tile.whole && only != nullptr && only->fills(tile.box))
            draw_filled(tile, *only, luma);
        else
            draw_pixels(tile, luma);
    }
}

void LensRenderer::find_candidates(const Box &box) {
    candidates_.clear();
    double filled = 0; // nothing behind this inverse depth can be seen
    std::size_t index = 0;
    for (const PlaneView &plane : surfaces_.planes()) {
        const double highest = plane.inverse_z().highest(box);
        if (highest > filled && plane.may_be_in(box)) {
            candidates_.push_back({index, highest});
            if (plane.fills(box))
                filled = std::max(filled, plane.inverse_z().lowest(box));
        }
        ++index;
    }
    for (const BallView &ball : surfaces_.balls()) {
        if (ball.may_be_in(box))
            candidates_.push_back({index, ball.highest_inverse_z()});
        ++index;
    }
    std::erase_if(candidates_, [&](const Candidate &c) { return c.highest_inverse_z < filled; });
}

void LensRenderer::draw_filled(const Tile &tile, const PlaneView &plane,
                               ImageView<std::uint8_t> luma) {
    for (int v = tile.v; v < tile.v + tile.height; ++v) {
        if (luma.empty()) {
            for (int u = tile.u; u < tile.u + tile.width; ++u) {
                const Eigen::Vector2d ray = rays_.at(u, v);
                z_.row(v)[u] = static_cast<float>(1 / plane.inverse_z()(ray.x(), ray.y()));
            }
        } else {
            plane.shade(rays_.places(tile.u, v, tile.width), z_.row(v) + tile.u,
                        luma.row(v) + tile.u);
        }
        if (!normals_.empty())
            std::fill_n(normals_.row(v) + tile.u, tile.width, plane.normal().cast<float>());
    }
}

void LensRenderer::draw_pixels(const Tile &tile, ImageView<std::uint8_t> luma) {
    for (int v = tile.v; v < tile.v + tile.height; ++v) {
        for (int u = tile.u; u < tile.u + tile.width; ++u) {
            const int fixed = draw_pixel(u, v, !luma.empty());
            if (!luma.empty())
                luma.row(v)[u] = static_cast<std::uint8_t>(std::clamp((fixed + 128) >> 8, 0, 255));
        }
    }
}

/// The surface seen along a ray.
struct LensRenderer::Seen {
    static constexpr std::size_t nothing = static_cast<std::size_t>(-1);
    std::size_t surface = nothing;
    double inverse_z = 0;
};

LensRenderer::Seen LensRenderer::look(double x, double y) const {
    Seen seen;
    for (const Candidate &candidate : candidates_) {
        const double inverse_z = surfaces_.inverse_z_if_seen(candidate.surface, x, y);
        if (inverse_z > seen.inverse_z)
            seen = {candidate.surface, inverse_z};
    }
    return seen;
}

/// Returns luma with 8 bits of fraction, if it is to be shaded.
int LensRenderer::draw_pixel(int u, int v, bool shade) {
    z_.row(v)[u] = 0;
    if (!rays_.is_seen(u, v))
        return 0;
    const Eigen::Vector2d ray = rays_.at(u, v);
    const Seen centre = look(ray.x(), ray.y());
    if (centre.surface != Seen::nothing) {
        z_.row(v)[u] = static_cast<float>(1 / centre.inverse_z);
        if (!normals_.empty()) {
            const PlaneView *plane = surfaces_.plane(centre.surface);
            const Eigen::Vector3d normal =
                plane != nullptr ? plane->normal()
                                 : surfaces_.ball(centre.surface).normal(ray.x(), ray.y());
            normals_.row(v)[u] = normal.cast<float>();
        }
    }
    if (!shade || candidates_.empty())
        return 0;
    const auto luma_of = [&, level = rays_.level(u, v)](const Seen &seen,
                                                        const Eigen::Vector2d &place) {
        return seen.surface == Seen::nothing
                   ? 0
                   : surfaces_.luma(seen.surface, place.x(), place.y(), level);
    };
    const Eigen::Matrix2d step = rays_.per_pixel(u, v);
    std::array<Eigen::Vector2d, places_in_pixel.size()> places;
    std::array<Seen, places_in_pixel.size()> seen;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto &[du, dv] = places_in_pixel[i];
        places[i] = ray + step * Eigen::Vector2d(du, dv);
        seen[i] = look(places[i].x(), places[i].y());
    }
    if (std::ranges::all_of(seen, [&](const Seen &s) { return s.surface == centre.surface; }))
        return luma_of(centre, ray);
    int sum = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
        sum += luma_of(seen[i], places[i]);
    return sum / static_cast<int>(places.size());
}

} // namespace afterglow
