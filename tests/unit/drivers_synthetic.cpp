// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/synthetic.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

const SyntheticOptions small{.width = 160, .height = 120, .real_time = false};

/// A wall 2 m before a camera that does not move, and nothing else.
SyntheticWorld wall_world(double size = 100) {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = {}};
    const int body = world.scene.add_body(at_rest());
    world.scene.add_wall(body, 2, size, world.scene.add_texture(make_texture(Pattern::print, 1)));
    return world;
}

struct Frame {
    ColorFrame color;
    DepthFrame depth;
};

/// The first `count` frames, all of them measured.
std::vector<Frame> film(const SyntheticOptions &options, const SyntheticWorld &world, int count) {
    auto rig = open_synthetic(options, world);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    Frame frame;
    frame.color.luma = Luma(options.width, options.height);
    frame.depth.depth = DepthMap(options.width, options.height);
    std::vector<Frame> frames;
    for (int k = 0; k < count; ++k) {
        REQUIRE(rig->color->read(frame.color, 0ns) == Capture::frame);
        REQUIRE(rig->tof->read(frame.depth, 0ns) == Capture::frame);
        frames.push_back(frame);
    }
    return frames;
}

double mean(LumaView luma) {
    double sum = 0;
    for (int v = 0; v < luma.height(); ++v) {
        for (int u = 0; u < luma.width(); ++u)
            sum += luma(u, v);
    }
    return sum / (luma.width() * luma.height());
}

} // namespace

TEST_CASE("synthetic frames depend on options and seed alone") {
    const auto first = film(small, make_world(small), 3);
    const auto again = film(small, make_world(small), 3);
    SyntheticOptions other = small;
    other.seed = 2;
    const auto different = film(other, make_world(other), 3);
    for (std::size_t k = 0; k < 3; ++k) {
        CHECK(first[k].color.luma == again[k].color.luma);
        CHECK(first[k].depth.depth == again[k].depth.depth);
        CHECK_FALSE(first[k].color.luma == different[k].color.luma);
    }
    CHECK(first[1].color.t_ns == 33'333'333);
}

TEST_CASE("synthetic noise does not depend on earlier measurements") {
    auto rig = open_synthetic(small);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    ColorFrame color{Luma(160, 120)};
    DepthFrame depth{DepthMap(160, 120)};
    for (int k = 0; k < 3; ++k)
        REQUIRE(rig->color->read(color, 0ns) == Capture::frame);
    CHECK(rig->tof->read(depth, 0ns) == Capture::none);
    REQUIRE(rig->illuminator->set(true));
    REQUIRE(rig->tof->read(depth, 0ns) == Capture::frame);
    CHECK(depth.depth == film(small, make_world(small), 3)[2].depth.depth);
}

TEST_CASE("the synthetic depth of a slanted plane is exact") {
    SyntheticWorld world = wall_world();
    const Pose camera_to_world{rotation({0.2, 0.5, 0.1}), {0.3, -0.2, 0.4}};
    world.camera = at_rest(camera_to_world);
    SyntheticTruth truth(small, world);
    const DepthMap depth = truth.depth(0);
    const Intrinsics camera = truth.intrinsics();
    for (int v = 0; v < camera.height; v += 7) {
        for (int u = 0; u < camera.width; u += 7) {
            // The point z d lies where the world's z is 2.
            const Eigen::Vector3d d = camera.back_project(u, v, 1);
            const double z = (2 - camera_to_world.T.z()) / (camera_to_world.R * d).z();
            CHECK(std::abs(depth(u, v) - 1000 * z) <= 0.51);
        }
    }
}

TEST_CASE("the synthetic depth of a sphere is exact") {
    SyntheticWorld world = wall_world();
    world.scene.spheres.push_back({.body = 0, .center = {0.2, 0.1, 1.5}, .radius = 0.3});
    SyntheticTruth truth(small, world);
    const DepthMap depth = truth.depth(0);
    const Intrinsics camera = truth.intrinsics();
    int on_sphere = 0;
    for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
            const Eigen::Vector3d point = camera.back_project(u, v, depth(u, v) / 1000.0);
            if (depth(u, v) == 2000)
                continue;
            ++on_sphere;
            CHECK((point - Eigen::Vector3d(0.2, 0.1, 1.5)).norm() == Approx(0.3).margin(0.002));
        }
    }
    // About pi r^2 (f / z)^2 pixels.
    CHECK(on_sphere > 1800);
    CHECK(on_sphere < 2800);
}

TEST_CASE("the synthetic depth of empty space is 0") {
    SyntheticTruth truth(small, wall_world(1));
    const DepthMap depth = truth.depth(0);
    CHECK(depth(80, 60) == 2000);
    CHECK(depth(0, 0) == 0);
    CHECK(film(small, wall_world(1), 1)[0].depth.depth(0, 0) == 0);
    // From behind a wall cannot be seen.
    SyntheticWorld behind = wall_world();
    behind.camera = at_rest({rotation({0, 3.14159, 0}), {0, 0, 4}});
    CHECK(SyntheticTruth(small, behind).depth(0) == DepthMap(160, 120));
}

TEST_CASE("the synthetic room has depth at every pixel along the camera's path") {
    SyntheticTruth truth(small);
    for (std::uint64_t k = 0; k < 3000; k += 150) {
        const DepthMap depth = truth.depth(k);
        const auto [nearest, furthest] =
            std::minmax_element(depth.pixels().begin(), depth.pixels().end());
        CHECK(*nearest > 100);
        CHECK(*furthest < 8000);
    }
}

TEST_CASE("synthetic depth and poses of two frames are consistent") {
    const std::uint64_t from = 100;
    const std::uint64_t to = 106;
    SyntheticTruth truth(small);
    const DepthMap first = truth.depth(from);
    const DepthMap second = truth.depth(to);
    const Luma first_luma = truth.luma(from);
    const Luma second_luma = truth.luma(to);
    const Pose motion = truth.world_to_camera(to) * truth.world_to_camera(from).inverse();
    REQUIRE(motion.T.norm() > 0.005);
    const Intrinsics camera = truth.intrinsics();
    int seen = 0, agree = 0, look_alike = 0;
    for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
            const Eigen::Vector3d X = motion * camera.back_project(u, v, first(u, v) / 1000.0);
            const Eigen::Vector2d p = camera.project(X);
            const int pu = static_cast<int>(std::lround(p.x()));
            const int pv = static_cast<int>(std::lround(p.y()));
            if (!second.view().contains(pu, pv))
                continue;
            ++seen;
            agree += std::abs(second(pu, pv) / 1000.0 - X.z()) < 0.02 * X.z();
            look_alike += std::abs(second_luma(pu, pv) - first_luma(u, v)) < 20;
        }
    }
    REQUIRE(seen > 160 * 120 / 2);
    CHECK(agree > 0.97 * seen);
    CHECK(look_alike > 0.9 * seen);
}

TEST_CASE("synthetic images move smoothly by fractions of a pixel") {
    // A twentieth of a pixel to the side at 2 m: the image changes by a twentieth of its slope.
    SyntheticOptions options = small;
    options.noise = false;
    const double pixel = 2 / synthetic_camera(options).fx;
    SyntheticWorld world = wall_world();
    world.scene.textures[0] = make_texture(Pattern::plaster, 1);
    world.camera = [pixel](double t) {
        return Pose{Eigen::Matrix3d::Identity(), {t * 30 * pixel / 20, 0, 0}};
    };
    const auto frames = film(options, world, 21);
    double step_sum = 0, biggest_step = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
        double step = 0;
        for (std::size_t i = 0; i < frames[k].color.luma.pixels().size(); ++i)
            step +=
                std::abs(frames[k].color.luma.pixels()[i] - frames[k - 1].color.luma.pixels()[i]);
        step_sum += step;
        biggest_step = std::max(biggest_step, step);
    }
    CHECK(step_sum > 0);
    CHECK(biggest_step < 1.5 * step_sum / 20); // no jumps
    // After 20 steps it has moved by exactly one pixel.
    const Luma &start = frames.front().color.luma;
    const Luma &end = frames.back().color.luma;
    double difference = 0;
    for (int v = 0; v < 120; ++v) {
        for (int u = 0; u < 159; ++u)
            difference += std::abs(end(u, v) - start(u + 1, v));
    }
    CHECK(difference / (120 * 159) < 0.6); // of rounding
}

TEST_CASE("synthetic patterns blur to their mean at a distance instead of aliasing") {
    SyntheticWorld world = wall_world(10'000);
    SyntheticOptions options = small;
    options.noise = false;
    world.camera = at_rest({Eigen::Matrix3d::Identity(), {0, 0, -600}});
    const Luma luma = film(options, world, 1)[0].color.luma;
    const double level = mean(luma);
    CHECK(level > 50);
    for (const std::uint8_t pixel : luma.pixels())
        CHECK(std::abs(pixel - level) < 3);
}

TEST_CASE("synthetic depth noise follows the noise model") {
    SyntheticWorld world = wall_world();
    world.tof = {.sigma_at_0 = 0.004, .sigma_per_square = 0.002};
    const auto frames = film(small, world, 2);
    double sum = 0, squares = 0;
    for (const std::uint16_t mm : frames[0].depth.depth.pixels()) {
        sum += mm - 2000;
        squares += (mm - 2000) * (mm - 2000);
    }
    const double count = 160 * 120;
    CHECK(std::abs(sum / count) < 0.5);
    CHECK(std::sqrt(squares / count) == Approx(4 + 2 * 4).epsilon(0.05));
    CHECK_FALSE(frames[0].depth.depth == frames[1].depth.depth);
}

TEST_CASE("synthetic depth beyond the TOF camera's range is 0") {
    SyntheticWorld world = wall_world();
    world.tof.furthest = 1.9;
    CHECK(film(small, world, 1)[0].depth.depth == DepthMap(160, 120));
    world.tof.furthest = 5;
    world.tof.nearest = 2.1;
    CHECK(film(small, world, 1)[0].depth.depth == DepthMap(160, 120));
}

TEST_CASE("synthetic depth saturates on bright near surfaces") {
    SyntheticWorld world = wall_world();
    world.tof.saturation = 0.5 / 4; // at 2 m, what is brighter than half
    SyntheticOptions options = small;
    const Luma luma = SyntheticTruth(options, world).luma(0);
    const DepthMap depth = film(options, world, 1)[0].depth.depth;
    int saturated = 0;
    for (std::size_t i = 0; i < luma.pixels().size(); ++i) {
        CHECK((depth.pixels()[i] == 0) == (luma.pixels()[i] > 127.5));
        saturated += depth.pixels()[i] == 0;
    }
    CHECK(saturated > 100);
    CHECK(saturated < 160 * 120 - 100);
}

TEST_CASE("synthetic flying pixels occur only at depth edges, between both depths") {
    SyntheticWorld world = wall_world();
    world.scene.add_box(0, {0, 0, 1.25}, {0.4, 0.3, 0.5}, 0); // its front is 1 m away
    world.tof = TofNoise::none();
    world.tof.flying = 1;
    world.tof.edge = 0.05;
    const DepthMap truth = SyntheticTruth(small, world).depth(0);
    const DepthMap depth = film(small, world, 1)[0].depth.depth;
    int flying = 0;
    for (int v = 1; v < 119; ++v) {
        for (int u = 1; u < 159; ++u) {
            const auto [low, high] = std::minmax(
                {truth(u, v), truth(u - 1, v), truth(u + 1, v), truth(u, v - 1), truth(u, v + 1)});
            CHECK(depth(u, v) >= low);
            CHECK(depth(u, v) <= high);
            flying += depth(u, v) != truth(u, v);
        }
    }
    // Most of the pixels on both sides of an outline of about 52 by 39 pixels.
    CHECK(flying > 200);
    CHECK(flying < 500);
}

TEST_CASE("synthetic noise can be disabled for both cameras") {
    SyntheticOptions options = small;
    options.noise = false;
    SyntheticTruth truth(options);
    const auto frames = film(options, make_world(options), 2);
    CHECK(frames[1].color.luma == truth.luma(1));
    CHECK(frames[1].depth.depth == truth.depth(1));
}

TEST_CASE("a synthetic object can move in front of a static camera") {
    SyntheticWorld world = wall_world();
    const int body = world.scene.add_body([](double t) {
        return Pose{Eigen::Matrix3d::Identity(), {t, 0, 1}}; // 1 m/s to the right
    });
    world.scene.add_box(body, {0, 0, 0}, {0.2, 0.2, 0.2}, 0);
    SyntheticTruth truth(small, world);
    const auto center = [&](std::uint64_t k) {
        const DepthMap depth = truth.depth(k);
        double sum = 0;
        int count = 0;
        for (int u = 0; u < 160; ++u) {
            if (depth(u, 60) == 900) {
                sum += u;
                ++count;
            }
        }
        REQUIRE(count > 10);
        return sum / count;
    };
    CHECK(center(0) == Approx(79.5).margin(1));
    CHECK(center(6) - center(0) == Approx(0.2 * 131.25 / 0.9).margin(1.5));
    CHECK((truth.world_to_camera(6).T - truth.world_to_camera(0).T).norm() == 0);
}

TEST_CASE("the synthetic hand-held camera has the configured speed, and none when static") {
    const Motion hand = hand_held(3, 1);
    const Motion tripod = hand_held(3, 0);
    double metres = 0, radians = 0;
    constexpr int steps = 3000;
    for (int k = 0; k < steps; ++k) {
        const Pose a = hand(k / 30.0);
        const Pose b = hand((k + 1) / 30.0);
        const double step = (b.T - a.T).norm();
        const double turn = (b.inverse() * a).angle();
        CHECK(step * 30 < 0.6);
        CHECK(turn * 30 < 0.9);
        CHECK(std::hypot(a.T.x(), a.T.z()) < 0.75);
        metres += step;
        radians += turn;
    }
    CHECK(metres / steps * 30 > 0.05);
    CHECK(radians / steps * 30 > 0.05);
    CHECK((tripod(100).T - tripod(0).T).norm() == 0);
    CHECK((hand_held(3, 2)(10).T - hand(20).T).norm() == Approx(0).margin(1e-12));
}

TEST_CASE("the synthetic cameras allocate nothing in steady state") {
    auto rig = open_synthetic(small);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame color{Luma(160, 120)};
    DepthFrame depth{DepthMap(160, 120)};
    bool good = true;
    const auto before = allocation_count();
    for (int k = 0; k < 50; ++k) {
        good = good && rig->color->read(color, 0ns) == Capture::frame;
        good = good && rig->tof->read(depth, 0ns) == Capture::frame;
    }
    CHECK(allocation_count() == before);
    CHECK(good);
}

TEST_CASE("synthetic options out of range are refused") {
    CHECK_FALSE(open_synthetic({.width = 0}));
    CHECK_FALSE(open_synthetic({.height = 100'000}));
    CHECK_FALSE(open_synthetic({.fps = 0}));
    CHECK_FALSE(open_synthetic({.fps = std::nan("")}));
    CHECK_FALSE(open_synthetic({.wake_latency_frames = -1}));
    CHECK_FALSE(open_synthetic({.frames = -1}));
    CHECK_FALSE(open_synthetic({.motion = -1}));
}
