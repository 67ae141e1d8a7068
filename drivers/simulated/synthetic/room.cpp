// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/random.hpp"
#include "drivers/simulated/synthetic/scene.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

const Eigen::Vector3d room_size(6, 2.7, 5);
constexpr double floor_y = 1.35;
constexpr double free_radius = 0.95;
constexpr int furniture = 11;

/// Turned about the vertical through (x, z), where the floor is.
Pose standing(double x, double z, double angle) {
    return {Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix(), {x, floor_y, z}};
}

/// A table with something on it, or a cupboard; the body's origin is on the floor.
void add_furniture(Scene &scene, int body, const Eigen::Vector3d &size,
                   const std::array<int, 4> &textures, Random &random) {
    const int texture = textures[static_cast<std::size_t>(random.below(4))];
    const int other = textures[static_cast<std::size_t>(random.below(4))];
    const double top = -size.y();
    if (size.y() < 1) {
        constexpr double leg = 0.05;
        scene.add_box(body, {0, top + leg / 2, 0}, {size.x(), leg, size.z()}, texture);
        for (const double x : {-0.5, 0.5}) {
            for (const double z : {-0.5, 0.5})
                scene.add_box(body, {x * (size.x() - leg), (top + leg) / 2, z * (size.z() - leg)},
                              {leg, size.y() - leg, leg}, texture);
        }
    } else {
        scene.add_box(body, {0, top / 2, 0}, size, texture);
    }
    const double side = random.uniform(0.15, 0.3);
    if (random.below(2) == 0)
        scene.add_box(body, {random.uniform(-0.1, 0.1), top - side / 2, 0},
                      {side, side, 1.3 * side}, other);
    else
        scene.spheres.push_back({.body = body,
                                 .center = {random.uniform(-0.1, 0.1), top - side / 2, 0},
                                 .radius = side / 2,
                                 .texture = other});
}

/// Pictures on the walls at z = +-room_size.z / 2 and x = +-room_size.x / 2.
void add_pictures(Scene &scene, int body, int texture, Random &random) {
    for (int i = 0; i < 8; ++i) {
        const bool on_z = i % 2 == 0;
        const double place = i % 4 < 2 ? 0.5 : -0.5;
        const double along = random.uniform(-0.4, 0.4);
        const double width = random.uniform(0.4, 0.9);
        const double height = random.uniform(0.3, 0.7);
        const double y = random.uniform(-0.6, 0.0);
        if (on_z)
            scene.add_box(body, {along * room_size.x(), y, place * room_size.z()},
                          {width, height, 0.05}, texture);
        else
            scene.add_box(body, {place * room_size.x(), y, along * room_size.z()},
                          {0.05, height, width}, texture);
    }
}

} // namespace

Scene make_room(std::uint64_t seed) {
    Random random(seed);
    Scene scene;
    const int plaster = scene.add_texture(make_texture(Pattern::plaster, random.next()));
    const int wood = scene.add_texture(make_texture(Pattern::wood, random.next()));
    const int tiles = scene.add_texture(make_texture(Pattern::tiles, random.next()));
    const int print = scene.add_texture(make_texture(Pattern::print, random.next()));
    const int poster = scene.add_texture(make_texture(Pattern::print, random.next()));
    const int room = scene.add_body(at_rest());
    scene.add_room(room, {0, 0, 0}, room_size, plaster, wood, plaster);
    add_pictures(scene, room, poster, random);

    // Furniture in a ring, each piece in its own sector and as far out as the walls let it.
    for (int i = 0; i < furniture; ++i) {
        const double angle = (i + random.uniform(0.2, 0.8)) * 2 * std::numbers::pi / furniture;
        // One by one: compilers differ in the order of a call's arguments.
        const double depth = random.uniform(0.3, 0.6);
        const double height = random.uniform(0.4, 1.6);
        const double width = random.uniform(0.3, 0.8);
        const Eigen::Vector3d size(width, height, depth);
        const double reach = std::hypot(size.x(), size.z()) / 2;
        const double to_wall = std::min(room_size.x() / 2 / std::abs(std::cos(angle)),
                                        room_size.z() / 2 / std::abs(std::sin(angle)));
        const double nearest = free_radius + reach;
        const double radius = random.uniform(nearest, std::max(nearest, to_wall - reach));
        const int body =
            scene.add_body(at_rest(standing(radius * std::cos(angle), radius * std::sin(angle),
                                            random.uniform(0, std::numbers::pi))));
        add_furniture(scene, body, size, {wood, tiles, print, poster}, random);
    }
    return scene;
}

} // namespace afterglow
