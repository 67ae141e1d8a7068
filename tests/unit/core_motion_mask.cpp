// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale.hpp"
#include "core/keyframe/expected_error.hpp"
#include "core/keyframe/keyframe_pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"

#include <Eigen/Geometry>

#include <algorithm>

using namespace afterglow;

namespace {

const SyntheticOptions options{
    .width = 320, .height = 240, .fps = 30, .seed = 1, .real_time = false, .noise = false};

/// Of a moving pixel, before a measurement has told how wrong they are.
const float unlearnt_moving_error = ErrorScale(0.45, 0.45).scale() * ErrorOptions{}.moving_error;

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

/// Tracks image 5 against the measured image 0.
struct Watched {
    explicit Watched(double speed)
        : truth(film(speed)), pool(1), pipeline(KeyframeOptions{}, truth.intrinsics(), pool) {
        for (std::uint64_t k = 0; k <= 5; ++k) {
            estimate = pipeline.track(truth.luma(k), static_cast<std::int64_t>(k + 1) * 33'333'333);
            if (k == 0)
                estimate = pipeline.measure(truth.depth(0));
        }
    }
    /// Share of the pixels with depth that are said to move.
    double distrusted() const {
        const std::uint8_t limit = estimated_confidence(unlearnt_moving_error);
        int low = 0, all = 0;
        for (int v = 0; v < options.height; ++v)
            for (int u = 0; u < options.width; ++u) {
                const std::uint8_t c = estimate.confidence(u, v);
                all += c > 0;
                low += c > 0 && c <= limit;
            }
        return static_cast<double>(low) / all;
    }

    SyntheticTruth truth;
    WorkerPool pool;
    KeyframePipeline pipeline;
    Estimate estimate;
};

} // namespace

TEST_CASE("the motion mask lowers confidence on a moving object and nowhere else", "[core]") {
    const Watched w(8); // 76 degrees
    REQUIRE(w.estimate.source == FrameSource::estimated);
    const std::uint8_t limit = estimated_confidence(unlearnt_moving_error);
    CHECK(w.estimate.confidence(175, 105) <= limit); // on the box
    CHECK(w.estimate.confidence(20, 120) > limit);
    CHECK(w.estimate.confidence(300, 40) > limit);
    CHECK(w.distrusted() > 0.05);
    CHECK(w.distrusted() < 0.3);
}

TEST_CASE("a moving object raises the expected error", "[core]") {
    const Watched moving(8), still(0);
    CHECK(moving.estimate.expected_mre > still.estimate.expected_mre + 0.5f);
}

TEST_CASE("the motion mask is empty for a rigid scene with occlusions", "[core]") {
    const Watched w(0);
    REQUIRE(w.estimate.source == FrameSource::estimated);
    CHECK(w.distrusted() == 0);
}

TEST_CASE("the motion mask is empty for a hand-held camera in a static room", "[core]") {
    SyntheticOptions room = options;
    room.noise = true;
    SyntheticTruth truth(room);
    WorkerPool pool(1);
    KeyframePipeline pipeline(KeyframeOptions{}, truth.intrinsics(), pool);
    const std::uint8_t limit = estimated_confidence(unlearnt_moving_error);
    std::int64_t low = 0, all = 0;
    for (std::uint64_t k = 0; k < 20; ++k) {
        Estimate e = pipeline.track(truth.luma(k), static_cast<std::int64_t>(k + 1) * 33'333'333);
        if (k % 10 == 0)
            e = pipeline.measure(truth.depth(k));
        for (int v = 0; v < room.height; ++v)
            for (int u = 0; u < room.width; ++u) {
                all += e.confidence(u, v) > 0;
                low += e.confidence(u, v) > 0 && e.confidence(u, v) <= limit;
            }
    }
    CHECK(low < all / 100);
}
