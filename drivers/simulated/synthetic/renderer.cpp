// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/renderer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

namespace afterglow {
namespace {

constexpr std::int16_t nothing = -1;

} // namespace

Renderer::Renderer(const Scene &scene, const Intrinsics &camera)
    : surfaces_(scene), camera_(camera), inverse_z_(camera.width, camera.height),
      z_(camera.width, camera.height), surface_(camera.width, camera.height, nothing) {
    assert(scene.quads.size() + scene.spheres.size() < 32767);
}

void Renderer::render(double t_s, const Pose &world_to_camera, ImageView<std::uint8_t> luma) {
    assert(luma.same_size(z_.view()));
    surfaces_.place(t_s, world_to_camera, camera_);
    for (int v = 0; v < camera_.height; ++v) {
        find_nearest(v);
        shade_row(v, luma.row(v));
    }
    smooth_edges(luma);
}

void Renderer::find_nearest(int v) {
    float *nearest = inverse_z_.row(v);
    std::int16_t *surface = surface_.row(v);
    std::fill_n(nearest, camera_.width, 0.0F);
    std::fill_n(surface, camera_.width, nothing);
    std::int16_t index = 0;
    for (const PlaneView &plane : surfaces_.planes()) {
        const Columns columns = plane.columns(v, camera_.width);
        const auto begin = static_cast<float>(plane.inverse_z()(columns.begin, v));
        const auto step = static_cast<float>(plane.inverse_z().a);
        for (int u = columns.begin; u < columns.end; ++u) {
            const float inverse_z = begin + step * static_cast<float>(u - columns.begin);
            if (inverse_z > nearest[u]) {
                nearest[u] = inverse_z;
                surface[u] = index;
            }
        }
        ++index;
    }
    for (const BallView &ball : surfaces_.balls()) {
        const Columns columns = ball.columns(v, camera_.width);
        for (int u = columns.begin; u < columns.end; ++u) {
            const auto inverse_z = static_cast<float>(ball.inverse_z_if_seen(u, v));
            if (inverse_z > nearest[u]) {
                nearest[u] = inverse_z;
                surface[u] = index;
            }
        }
        ++index;
    }
}

void Renderer::shade_row(int v, std::uint8_t *luma) {
    const float *inverse_z = inverse_z_.row(v);
    const std::int16_t *surface = surface_.row(v);
    float *z = z_.row(v);
    for (int begin = 0, end = 0; begin < camera_.width; begin = end) {
        const std::int16_t index = surface[begin];
        while (end < camera_.width && surface[end] == index)
            ++end;
        if (index == nothing) {
            std::fill(z + begin, z + end, 0.0F);
            std::fill(luma + begin, luma + end, std::uint8_t{0});
        } else if (const PlaneView *plane = surfaces_.plane(static_cast<std::size_t>(index))) {
            plane->shade(begin, v, {inverse_z + begin, inverse_z + end}, z + begin, luma + begin);
        } else {
            const BallView &ball = surfaces_.ball(static_cast<std::size_t>(index));
            for (int u = begin; u < end; ++u) {
                z[u] = 1 / inverse_z[u];
                luma[u] = static_cast<std::uint8_t>(std::clamp(ball.luma(u, v) >> 8, 0, 255));
            }
        }
    }
}

void Renderer::smooth_edges(ImageView<std::uint8_t> luma) const {
    for (int v = 0; v < camera_.height; ++v) {
        const std::int16_t *above = surface_.row(std::max(v - 1, 0));
        const std::int16_t *row = surface_.row(v);
        const std::int16_t *below = surface_.row(std::min(v + 1, camera_.height - 1));
        for (int u = 0; u < camera_.width; ++u) {
            const std::int16_t here = row[u];
            if (above[u] != here || below[u] != here || row[std::max(u - 1, 0)] != here ||
                row[std::min(u + 1, camera_.width - 1)] != here)
                luma.row(v)[u] = sample_pixel(u, v, luma.row(v)[u]);
        }
    }
}

std::uint8_t Renderer::sample_pixel(int u, int v, std::uint8_t otherwise) const {
    // What can be seen in a pixel is seen at a neighbour's centre, but for slivers.
    std::array<std::int16_t, 9> candidates{};
    auto *end = candidates.begin();
    for (int y = std::max(v - 1, 0); y <= std::min(v + 1, camera_.height - 1); ++y) {
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, camera_.width - 1); ++x) {
            const std::int16_t index = surface_.row(y)[x];
            if (index != nothing && std::find(candidates.begin(), end, index) == end)
                *end++ = index;
        }
    }
    int sum = 0;
    for (const auto &[du, dv] : places_in_pixel) {
        double nearest = 0;
        std::size_t seen = 0;
        for (const auto *candidate = candidates.begin(); candidate != end; ++candidate) {
            const auto index = static_cast<std::size_t>(*candidate);
            const double inverse_z = surfaces_.inverse_z_if_seen(index, u + du, v + dv);
            if (inverse_z > nearest) {
                nearest = inverse_z;
                seen = index;
            }
        }
        sum += nearest > 0 ? surfaces_.luma(seen, u + du, v + dv) : otherwise << 8;
    }
    return static_cast<std::uint8_t>(std::clamp((sum / 4 + 128) >> 8, 0, 255));
}

} // namespace afterglow
