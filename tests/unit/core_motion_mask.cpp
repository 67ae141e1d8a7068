// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/two_lenses.hpp"

#include <Eigen/Geometry>

#include <algorithm>

using namespace afterglow;

namespace {

const SyntheticOptions options{
    .width = 320, .height = 240, .fps = 30, .seed = 1, .real_time = false, .noise = false};

/// A printed wall 2.5 m ahead and a box 1.2 m ahead, which turns like a wheel at `speed` rad/s, in
/// front of a camera that goes up at 0.2 m/s. Fast turns are no displacements of its parts.
SyntheticTruth film(double speed) {
    SyntheticWorld world{.scene = {}, .camera = {}, .tof = TofNoise::none()};
    const int wall = world.scene.add_texture(make_texture(Pattern::print, 1));
    const int print = world.scene.add_texture(make_texture(Pattern::print, 2));
    const int still = world.scene.add_body(at_rest());
    const int mover = world.scene.add_body([speed](double t_s) {
        return Pose{rotation({0, 0, speed * t_s}), {0, 0, 0}};
    });
    world.scene.add_wall(still, 2.5, 20, wall);
    world.scene.add_box(mover, {0, 0, 1.4}, {0.5, 0.5, 0.4}, print);
    world.camera = [](double t_s) { return Pose{Eigen::Matrix3d::Identity(), {0, -0.2 * t_s, 0}}; };
    return {options, std::move(world)};
}

/// A printed wall 2.5 m ahead on the left and a plain bright one 3 m ahead on the right, before
/// which a plain box slides to the right at 1.5 m/s.
SyntheticTruth plain_film(std::uint8_t luma_of_box) {
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = TofNoise::none()};
    const int print = world.scene.add_texture(make_texture(Pattern::print, 1));
    const int bright = testing::add_plain_texture(world.scene, 180);
    const int plain = testing::add_plain_texture(world.scene, luma_of_box);
    const int still = world.scene.add_body(at_rest());
    const int mover = world.scene.add_body([](double t_s) {
        return Pose{Eigen::Matrix3d::Identity(), {1.5 * t_s, 0, 0}};
    });
    world.scene.add_wall(still, 3, 20, bright);
    world.scene.add_box(still, {-1.6, 0, 2.6}, {3, 4, 0.2}, print);
    world.scene.add_box(mover, {0.4, 0, 1.7}, {0.4, 0.8, 0.2}, plain);
    return {options, std::move(world)};
}

/// Tracks image 5 against the measured image 0.
struct Watched {
    explicit Watched(double speed) : Watched(film(speed)) {}
    explicit Watched(SyntheticTruth seen)
        : truth(std::move(seen)), pool(1), pipeline(KeyframeOptions{}, truth.intrinsics(), pool) {
        for (std::uint64_t k = 0; k <= 5; ++k) {
            estimate = pipeline.track(truth.luma(k), static_cast<std::int64_t>(k + 1) * 33'333'333);
            if (k == 0)
                estimate = pipeline.measure(truth.depth(0));
        }
    }
    SyntheticTruth truth;
    WorkerPool pool;
    KeyframePipeline pipeline;
    Estimate estimate;
};

} // namespace

TEST_CASE("a moving box that cannot be followed has no depth, and the gate is told of it",
          "[core]") {
    const Watched moving(8), still(0); // 76 degrees
    REQUIRE(moving.estimate.source == FrameSource::estimated);
    int on_box = 0, beside = 0; // empty because of the motion
    for (int v = 0; v < options.height; ++v)
        for (int u = 0; u < options.width; ++u) {
            const bool empty = still.estimate.depth(u, v) != 0 && moving.estimate.depth(u, v) == 0;
            const bool near_box = u > 60 && u < 260 && v > 20 && v < 220;
            on_box += empty && near_box;
            beside += empty && !near_box;
        }
    CHECK(on_box > 0.05 * options.width * options.height);
    CHECK(beside < 0.01 * options.width * options.height);
    CHECK(moving.estimate.relative_coverage < still.estimate.relative_coverage - 5);
    CHECK(moving.estimate.moved_mre ==
          Approx(100 * ErrorOptions{}.moving_error * (on_box + beside) /
                 (0.01 * still.estimate.coverage * options.width * options.height))
              .epsilon(0.1));
}

TEST_CASE("a plain box that slides before a brighter plain wall is seen to move", "[core]") {
    // Neither has points that a template could have.
    Watched dark(plain_film(40)), alike(plain_film(160));
    const auto shown_too_far = [](Watched &watched) {
        REQUIRE(watched.estimate.source == FrameSource::estimated);
        const DepthMap depth = watched.truth.depth(5);
        int pixels = 0;
        for (int v = 0; v < options.height; ++v)
            for (int u = 0; u < options.width; ++u)
                pixels += watched.estimate.depth(u, v) > depth(u, v) + 500;
        return pixels;
    };
    // 34 x 127 pixels that the box has come to hide. 20 grey values may be light that has changed.
    CHECK(shown_too_far(dark) < 100);
    CHECK(shown_too_far(alike) > 3000);
    CHECK(dark.estimate.moved_mre > 0);
}

TEST_CASE("a cell moves when its mean grey value differs, unless it has a depth edge or is black",
          "[core]") {
    const Intrinsics camera{
        .fx = 300, .fy = 300, .cx = 159.5, .cy = 119.5, .width = 320, .height = 240};
    constexpr int level = 1, cell = MotionMask::cell_px;
    // Two columns of cells on the left, in one of the images.
    const auto band = [&](std::uint8_t luma) {
        Pyramid image(camera.width, camera.height, level);
        Luma picture(camera.width, camera.height, 180);
        for (int v = 0; v < camera.height; ++v)
            std::fill_n(picture.row(v), 2 * cell, luma);
        image.build(picture);
        return image;
    };
    const auto moving = [&](const Pyramid &then, const Pyramid &now, float contrast = 1) {
        DepthMap depth(camera.width, camera.height, 2000);
        std::fill_n(depth.row(0), camera.width * cell, std::uint16_t{0}); // of a row of cells
        std::fill_n(depth.row(cell), camera.width * cell / 2, std::uint16_t{1500}); // an edge
        WorkerPool pool(1);
        MotionMask mask(camera, level, pool);
        mask.add_unlike({then.level(level), 1, contrast}, now, {}, depth);
        const auto cells = mask.moving();
        int band_cells = 0, others = 0;
        for (int y = 0; y < cells.height(); ++y)
            for (int x = 0; x < cells.width(); ++x)
                (x < 2 && y >= 2 ? band_cells : others) += cells(x, y);
        CHECK(others == 0);
        return band_cells;
    };
    constexpr int all = 10; // of five rows; the last row of cells is not whole
    CHECK(moving(band(180), band(120)) == all);
    CHECK(moving(band(120), band(180)) == all);
    CHECK(moving(band(180), band(140)) == 0);
    CHECK(moving(band(180), band(140), 0.5f) == all); // a dim keyframe
    CHECK(moving(band(180), band(0)) == 0);           // what a lens does not show
    CHECK(moving(band(0), band(180)) == 0);
}

TEST_CASE("no pixel is left empty for motion in a rigid scene with occlusions", "[core]") {
    const Watched w(0);
    REQUIRE(w.estimate.source == FrameSource::estimated);
    CHECK(w.estimate.moved_mre == 0);
}

TEST_CASE("fewer than 1 % of the pixels are left empty for motion in a static room with noise",
          "[core]") {
    SyntheticOptions room = options;
    room.noise = true;
    SyntheticTruth truth(room);
    WorkerPool pool(1);
    KeyframePipeline pipeline(KeyframeOptions{}, truth.intrinsics(), pool);
    double left_empty = 0; // shares of the pixels
    for (std::uint64_t k = 0; k < 20; ++k) {
        Estimate e = pipeline.track(truth.luma(k), static_cast<std::int64_t>(k + 1) * 33'333'333);
        left_empty += e.moved_mre / (100 * ErrorOptions{}.moving_error);
        if (k % 10 == 0) {
            e = pipeline.measure(truth.depth(k));
            CHECK(e.moved_mre == 0);
        }
    }
    CHECK(left_empty / 20 < 0.01);
}
