// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/simulated/synthetic/motion.hpp"
#include "drivers/simulated/synthetic/texture.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace afterglow {

/// A flat rectangle, seen from one side only: that from which `right` x `down` points away.
struct Quad {
    int body = 0; ///< index into Scene::bodies, in whose frame the rest is, metres
    Eigen::Vector3d corner;
    Eigen::Vector3d right; ///< unit vector, along the texture's rows
    Eigen::Vector3d down;  ///< unit vector at right angles to it, along its columns
    double width = 0;
    double height = 0;
    int texture = 0; ///< index into Scene::textures
    double brightness = 1;
    Eigen::Vector2d texture_offset = {0, 0}; ///< metres, of the corner in the texture
};

struct Sphere {
    int body = 0;
    Eigen::Vector3d center;
    double radius = 0;
    int texture = 0;
    double brightness = 1;
};

/// What there is to see. World and body axes as a camera's: x right, y down, z forward; metres.
struct Scene {
    std::vector<Motion> bodies;
    std::vector<Quad> quads;
    std::vector<Sphere> spheres;
    std::vector<Texture> textures;

    /// Each returns the index of what it added.
    int add_texture(Texture texture);
    int add_body(Motion motion);
    /// A square of `size` metres, centred on the body's z axis and at right angles to it, seen by
    /// who looks along z.
    void add_wall(int body, double distance, double size, int texture);
    /// The outside of a box: six sides, each a little brighter or darker than the others.
    void add_box(int body, const Eigen::Vector3d &center, const Eigen::Vector3d &size, int texture);
    /// The inside of a box: four walls, floor and ceiling.
    void add_room(int body, const Eigen::Vector3d &center, const Eigen::Vector3d &size,
                  int wall_texture, int floor_texture, int ceiling_texture);
};

/// A furnished room of 6 x 2.7 x 5 m about the origin, where 0.9 m around the vertical through the
/// origin are kept free for the camera. The same seed gives the same room everywhere.
Scene make_room(std::uint64_t seed);

} // namespace afterglow
