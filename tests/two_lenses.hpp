// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/simulated/synthetic/synthetic.hpp"
#include "tests/catch.hpp"

#include <chrono>
#include <cstdint>
#include <vector>

namespace afterglow::testing {

/// 110 degrees from side to side.
inline const CameraModel fisheye{.pinhole = {170, 170, 161, 88, 320, 180},
                                 .lens = Lens::kannala_brandt,
                                 .distortion = {-0.02, 0.003, -0.001, 0.0002}};
inline const CameraModel barrel{.pinhole = {150, 152, 110, 87, 224, 172},
                                .lens = Lens::brown_conrady,
                                .distortion = {-0.25, 0.07, 0.001, -0.0008, 0.004, 0.01, 0.002, 0}};

/// A fisheye, and a TOF camera 3 cm beside it that looks a little elsewhere.
inline RigCalibration two_lenses() {
    return {.color = fisheye,
            .tof = barrel,
            .tof_from_color = {rotation({0.01, -0.02, 0.015}), {-0.03, 0.002, 0.001}}};
}

inline SyntheticOptions options_of(const RigCalibration &rig) {
    return {.real_time = false, .noise = false, .rig = rig};
}

/// A wall 2 m before a camera at rest.
inline SyntheticWorld wall_world() {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
    const int body = world.scene.add_body(at_rest());
    world.scene.add_wall(body, 2, 100, world.scene.add_texture(make_texture(Pattern::print, 1)));
    return world;
}

inline int add_plain_texture(Scene &scene, std::uint8_t luma) {
    return scene.add_texture(Texture(
        std::vector<std::uint8_t>(static_cast<std::size_t>(Texture::size) * Texture::size, luma)));
}

/// A wall 2 m away, of one colour.
inline SyntheticWorld plain_wall(std::uint8_t luma) {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
    const int texture = add_plain_texture(world.scene, luma);
    world.scene.add_wall(world.scene.add_body(at_rest()), 2, 100, texture);
    return world;
}

struct Frame {
    ColorFrame color;
    DepthFrame depth;
};

/// Image k and its measured depth.
inline Frame shoot(const SyntheticOptions &options, const SyntheticWorld &world, int k = 0) {
    constexpr std::chrono::nanoseconds at_once(0);
    auto rig = open_synthetic(options, world);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    Frame frame;
    const Intrinsics &color = rig->color->intrinsics();
    const Intrinsics &tof = rig->tof->intrinsics();
    frame.color.luma = Luma(color.width, color.height);
    frame.depth.depth = DepthMap(tof.width, tof.height);
    for (int i = 0; i <= k; ++i)
        REQUIRE(rig->color->read(frame.color, at_once) == Capture::frame);
    REQUIRE(rig->tof->read(frame.depth, at_once) == Capture::frame);
    return frame;
}

} // namespace afterglow::testing
