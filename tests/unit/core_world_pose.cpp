// SPDX-License-Identifier: Apache-2.0
//
// Where the camera is in the world, as both pipelines tell it: free odometry for robots.
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <algorithm>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr int frames = 24;
const SyntheticOptions options{.width = 320, .height = 240, .noise = false, .motion = 2};

/// What is known before the first measurement: nothing.
void check_nowhere(const Estimate &estimate) {
    CHECK(estimate.world == 0);
    CHECK_FALSE(estimate.tracked);
}

} // namespace

TEST_CASE("poses in the world follow the true camera across measurements", "[core]") {
    const auto method = GENERATE(Method::keyframe, Method::paper);
    const Film room = film_room(options.width, options.height, frames, options.motion);
    const SyntheticTruth truth(options, make_world(options));
    EstimatorOptions estimator;
    estimator.method = method;
    Viewer viewer(room, estimator);
    check_nowhere(viewer.track(0));
    CHECK(viewer.measure(0).world == 1);
    double moved = 0;
    for (int k = 1; k < frames; ++k) {
        const Estimate *estimate = &viewer.track(k);
        if (k % 6 == 0)
            estimate = &viewer.measure(k);
        CHECK(estimate->world == 1);
        CHECK(estimate->tracked);
        // The world's origin is the first measured frame's camera.
        const Pose seen = truth.world_to_camera(0) *
                          truth.world_to_camera(static_cast<std::uint64_t>(k)).inverse();
        moved = std::max(moved, seen.T.norm());
        const Pose error = estimate->world_from_camera * seen.inverse();
        INFO("frame " << k << ": " << 1000 * error.T.norm() << " mm");
        // A small shift and a small turn look alike: the depth is right where both are a bit wrong.
        CHECK(error.T.norm() < 0.02);
        CHECK(error.angle() < 0.01);
    }
    CHECK(moved > 0.06);
}

TEST_CASE("a pause begins a new world, and keeps no depth of the old one", "[core]") {
    const auto method = GENERATE(Method::keyframe, Method::paper);
    const Film room = film_room(options.width, options.height, 3);
    EstimatorOptions estimator;
    estimator.method = method;
    Viewer viewer(room, estimator);
    viewer.track(0);
    viewer.measure(0);
    CHECK(viewer.track(1).source == FrameSource::estimated);
    viewer.restart();
    const Estimate &woken = viewer.track(2);
    CHECK(woken.source == FrameSource::none);
    CHECK_FALSE(woken.tracked);
    CHECK(woken.wants_measurement);
    const Estimate &measured = viewer.measure(2);
    CHECK(measured.world == 2);
    CHECK(measured.world_from_camera.T.norm() < 1e-9);
    CHECK(measured.world_from_camera.angle() < 1e-6);
}

TEST_CASE("a camera that is lost for some frames begins a new world", "[core]") {
    const Film room = film_room(options.width, options.height, 2);
    Viewer viewer(room);
    viewer.track(0);
    viewer.measure(0);
    const Luma black(options.width, options.height);
    CHECK_FALSE(viewer.track(black).tracked);
    DepthMap other(options.width, options.height);
    std::ranges::fill(other.pixels(), std::uint16_t{700}); // nothing like the room
    CHECK(viewer.measure(other).world == 2);
}
