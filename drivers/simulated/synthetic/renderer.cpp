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
    : scene_(scene), camera_(camera), inverse_z_(camera.width, camera.height),
      z_(camera.width, camera.height), surface_(camera.width, camera.height, nothing) {
    assert(scene.quads.size() + scene.spheres.size() < 32767);
    planes_.reserve(scene.quads.size());
    balls_.reserve(scene.spheres.size());
}

void Renderer::render(double t_s, const Pose &world_to_camera, ImageView<std::uint8_t> luma) {
    assert(luma.same_size(z_.view()));
    place_surfaces(t_s, world_to_camera);
    for (int v = 0; v < camera_.height; ++v) {
        find_nearest(v);
        shade_row(v, luma.row(v));
    }
    smooth_edges(luma);
}

void Renderer::place_surfaces(double t_s, const Pose &world_to_camera) {
    planes_.clear();
    balls_.clear();
    const auto texture = [&](int index) -> const Texture & {
        return scene_.textures[static_cast<std::size_t>(index)];
    };
    int body = -1;
    Pose body_to_camera;
    const auto place = [&](int next_body) { // surfaces of a body most often follow each other
        if (next_body != body)
            body_to_camera =
                world_to_camera * scene_.bodies[static_cast<std::size_t>(next_body)](t_s);
        body = next_body;
    };
    for (const Quad &quad : scene_.quads) {
        place(quad.body);
        const PlaneView plane(quad, texture(quad.texture), body_to_camera, camera_);
        if (plane.faces_camera())
            planes_.push_back(plane);
    }
    for (const Sphere &sphere : scene_.spheres) {
        place(sphere.body);
        balls_.emplace_back(sphere, texture(sphere.texture), body_to_camera, camera_);
    }
}

void Renderer::find_nearest(int v) {
    float *nearest = inverse_z_.row(v);
    std::int16_t *surface = surface_.row(v);
    std::fill_n(nearest, camera_.width, 0.0F);
    std::fill_n(surface, camera_.width, nothing);
    std::int16_t index = 0;
    for (const PlaneView &plane : planes_) {
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
    for (const BallView &ball : balls_) {
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
        } else if (static_cast<std::size_t>(index) < planes_.size()) {
            planes_[static_cast<std::size_t>(index)].shade(
                begin, v, {inverse_z + begin, inverse_z + end}, z + begin, luma + begin);
        } else {
            const BallView &ball = balls_[static_cast<std::size_t>(index) - planes_.size()];
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
    constexpr std::array<std::array<double, 2>, 4> places = {
        {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};
    int sum = 0;
    for (const auto &[du, dv] : places) {
        double nearest = 0;
        std::size_t seen = 0;
        for (const auto *candidate = candidates.begin(); candidate != end; ++candidate) {
            const auto index = static_cast<std::size_t>(*candidate);
            const double inverse_z =
                index < planes_.size()
                    ? planes_[index].inverse_z_if_seen(u + du, v + dv)
                    : balls_[index - planes_.size()].inverse_z_if_seen(u + du, v + dv);
            if (inverse_z > nearest) {
                nearest = inverse_z;
                seen = index;
            }
        }
        if (nearest <= 0)
            sum += otherwise << 8;
        else if (seen < planes_.size())
            sum += planes_[seen].luma(u + du, v + dv);
        else
            sum += balls_[seen - planes_.size()].luma(u + du, v + dv);
    }
    return static_cast<std::uint8_t>(std::clamp((sum / 4 + 128) >> 8, 0, 255));
}

} // namespace afterglow
