// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/surface_set.hpp"

namespace afterglow {

SurfaceSet::SurfaceSet(const Scene &scene) : scene_(scene) {
    planes_.reserve(scene.quads.size());
    balls_.reserve(scene.spheres.size());
}

void SurfaceSet::place(double t_s, const Pose &world_to_camera, const Intrinsics &camera) {
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
        const PlaneView plane(quad, texture(quad.texture), body_to_camera, camera);
        if (plane.faces_camera())
            planes_.push_back(plane);
    }
    for (const Sphere &sphere : scene_.spheres) {
        place(sphere.body);
        balls_.emplace_back(sphere, texture(sphere.texture), body_to_camera, camera);
    }
}

} // namespace afterglow
