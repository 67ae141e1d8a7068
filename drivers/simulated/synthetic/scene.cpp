// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/scene.hpp"

#include <Eigen/Geometry>

#include <array>
#include <utility>

namespace afterglow {
namespace {

/// One side of a box, as it is looked at: `right` x `down` is the direction of the look.
struct Side {
    Eigen::Vector3d right;
    Eigen::Vector3d down;
    double brightness;
};

/// Along z, -z, x, -x, down and up; lit from above and from the left.
const std::array<Side, 6> sides = {{
    {{1, 0, 0}, {0, 1, 0}, 0.92},
    {{-1, 0, 0}, {0, 1, 0}, 0.80},
    {{0, 0, -1}, {0, 1, 0}, 1.00},
    {{0, 0, 1}, {0, 1, 0}, 0.72},
    {{1, 0, 0}, {0, 0, -1}, 1.10},
    {{1, 0, 0}, {0, 0, 1}, 0.60},
}};

/// The side of a box that a look meets where it enters (`place` -1) or leaves (1).
Quad side_of(const Side &side, int body, const Eigen::Vector3d &center, const Eigen::Vector3d &size,
             double place, int texture) {
    const Eigen::Vector3d away = side.right.cross(side.down);
    const double width = side.right.cwiseAbs().dot(size);
    const double height = side.down.cwiseAbs().dot(size);
    const double depth = away.cwiseAbs().dot(size);
    return {.body = body,
            .corner = center + (place * depth * away - width * side.right - height * side.down) / 2,
            .right = side.right,
            .down = side.down,
            .width = width,
            .height = height,
            .texture = texture,
            .brightness = side.brightness};
}

} // namespace

int Scene::add_texture(Texture texture) {
    textures.push_back(std::move(texture));
    return static_cast<int>(textures.size()) - 1;
}

int Scene::add_body(Motion motion) {
    bodies.push_back(std::move(motion));
    return static_cast<int>(bodies.size()) - 1;
}

void Scene::add_wall(int body, double distance, double size, int texture) {
    quads.push_back({.body = body,
                     .corner = {-size / 2, -size / 2, distance},
                     .right = {1, 0, 0},
                     .down = {0, 1, 0},
                     .width = size,
                     .height = size,
                     .texture = texture});
}

void Scene::add_box(int body, const Eigen::Vector3d &center, const Eigen::Vector3d &size,
                    int texture) {
    // Each side shows another part of the pattern.
    Eigen::Vector2d offset(0, 0);
    for (const Side &side : sides) {
        quads.push_back(side_of(side, body, center, size, -1, texture));
        quads.back().texture_offset = offset;
        offset += Eigen::Vector2d(0.83, 0.57);
    }
}

void Scene::add_room(int body, const Eigen::Vector3d &center, const Eigen::Vector3d &size,
                     int wall_texture, int floor_texture, int ceiling_texture) {
    // Sides reach a little behind each other, so that no pixel falls between them.
    constexpr double overlap = 0.001;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const int texture = i == 4 ? floor_texture : i == 5 ? ceiling_texture : wall_texture;
        Quad quad = side_of(sides[i], body, center, size, 1, texture);
        quad.corner -= overlap * (quad.right + quad.down);
        quad.width += 2 * overlap;
        quad.height += 2 * overlap;
        quad.texture_offset = 0.61 * static_cast<double>(i) * Eigen::Vector2d(1, 1);
        quads.push_back(quad);
    }
}

} // namespace afterglow
