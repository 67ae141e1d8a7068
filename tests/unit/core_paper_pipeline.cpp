// SPDX-License-Identifier: Apache-2.0
#include "core/pipeline.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

using namespace afterglow;

namespace {

const Intrinsics camera{200, 200, 159.5, 119.5, 320, 240};
constexpr std::int64_t frame_ns = 33'333'333;

/// A textured wall 2 m ahead, with the camera `shift` pixels to the left of where it was: the
/// image content has moved right by so much.
Luma wall(int shift) {
    Luma image(320, 240);
    for (int v = 0; v < 240; ++v) {
        for (int u = 0; u < 320; ++u) {
            const double x = u - shift;
            image(u, v) = static_cast<std::uint8_t>(128 + 50 * std::sin(0.11 * x + 0.02 * v) +
                                                    40 * std::sin(0.07 * v - 0.05 * x) +
                                                    20 * std::sin(0.19 * (x + v)));
        }
    }
    return image;
}

struct Fixture {
    explicit Fixture(int workers = 1)
        : pool(workers), pipeline(pipeline_factory(*estimator_preset("paper"), pool)(camera)) {}
    const Estimate &track(const Luma &image) { return pipeline->track(image, t_ns += frame_ns); }

    WorkerPool pool;
    std::unique_ptr<Pipeline> pipeline;
    std::int64_t t_ns = 0;
};

} // namespace

TEST_CASE("the estimator asks for a measurement and has no depth before the first one", "[core]") {
    Fixture f;
    for (int i = 0; i < 3; ++i) {
        const Estimate &e = f.track(wall(i));
        CHECK(e.source == FrameSource::none);
        CHECK(e.wants_measurement);
        CHECK(e.coverage == 0);
        CHECK(
            std::all_of(e.depth.data(), e.depth.data() + 320 * 240, [](int z) { return z == 0; }));
    }
}

TEST_CASE("the estimator publishes a measured map unchanged", "[core]") {
    Fixture f;
    f.track(wall(0));
    DepthMap depth(320, 240, 2000);
    depth(3, 4) = 0;
    const Estimate &e = f.pipeline->measure(depth);
    CHECK(e.source == FrameSource::measured);
    CHECK(e.age_frames == 0);
    CHECK(e.age_ns == 0);
    CHECK_FALSE(e.wants_measurement);
    CHECK(std::equal(depth.pixels().begin(), depth.pixels().end(), e.depth.data()));
    CHECK(e.confidence(3, 4) == 0);
    CHECK(e.confidence(4, 4) == 255);
}

TEST_CASE("the paper's estimator follows sideways motion over several frames", "[core]") {
    Fixture f;
    f.track(wall(0));
    f.pipeline->measure(DepthMap(320, 240, 2000));
    for (int i = 1; i <= 5; ++i) {
        const Estimate &e = f.track(wall(3 * i));
        REQUIRE(e.source == FrameSource::estimated);
        CHECK(e.age_frames == static_cast<std::uint32_t>(i));
        CHECK(e.age_ns == i * frame_ns);
        CHECK(e.inliers > e.matches / 2);
        CHECK(e.pose.T.x() == Approx(0.03 * i).margin(0.01)); // 3 px at f = 200 px, 2 m
        CHECK(e.pose.angle() < 0.005);
        CHECK(e.depth(160, 120) == Approx(2000).margin(10));
        CHECK(e.depth(1, 120) == 0); // came into view, never measured
        CHECK(e.confidence(1, 120) == no_confidence);
        CHECK(e.confidence(160, 120) == unknown_confidence);
    }
}

TEST_CASE("the estimator asks for a measurement when an image has no matches with the last",
          "[core]") {
    Fixture f;
    f.track(wall(0));
    f.pipeline->measure(DepthMap(320, 240, 2000));
    Luma noise(320, 240);
    std::mt19937 random(1);
    for (std::uint8_t &pixel : noise.pixels())
        pixel = static_cast<std::uint8_t>(random());
    const Estimate &e = f.track(noise);
    CHECK(e.source == FrameSource::none);
    CHECK(e.wants_measurement);

    SECTION("the request stays although later images match") {
        CHECK(f.track(wall(0)).source == FrameSource::none);
    }
    SECTION("a measurement ends the request") {
        f.track(wall(2));
        f.pipeline->measure(DepthMap(320, 240, 1500));
        CHECK(f.track(wall(2)).source == FrameSource::estimated);
    }
}

TEST_CASE("the estimator makes no estimate from a measured map of zeros", "[core]") {
    Fixture f;
    f.track(wall(0));
    f.pipeline->measure(DepthMap(320, 240, 0));
    const Estimate &e = f.track(wall(1));
    CHECK(e.source == FrameSource::none);
    CHECK(e.wants_measurement);
}

TEST_CASE("the estimator invents no depth from bad images and bad depth", "[core]") {
    Fixture f;
    std::mt19937 random(2);
    for (int kind = 0; kind < 24; ++kind) {
        Luma image(320, 240, static_cast<std::uint8_t>(kind % 3 == 0 ? 0 : 255));
        if (kind % 3 == 2)
            for (std::uint8_t &pixel : image.pixels())
                pixel = static_cast<std::uint8_t>(random() % 2 ? 255 : 0);
        const Estimate &tracked = f.track(image);
        CHECK(tracked.pose.is_finite());
        CHECK(std::isfinite(tracked.coverage));
        DepthMap depth(320, 240, static_cast<std::uint16_t>(kind % 4 == 0 ? 65535 : 1));
        if (kind % 4 == 2)
            for (std::uint16_t &z : depth.pixels())
                z = static_cast<std::uint16_t>(random() % 2 ? 65535 : 0);
        const Estimate &measured = f.pipeline->measure(depth);
        CHECK(measured.source == FrameSource::measured);
    }
}

TEST_CASE("the paper's estimate is identical for any number of workers", "[core]") {
    const auto run = [](int workers) {
        Fixture f(workers);
        f.track(wall(0));
        DepthMap depth(320, 240);
        for (int v = 0; v < 240; ++v)
            for (int u = 0; u < 320; ++u)
                depth(u, v) = static_cast<std::uint16_t>(1500 + 3 * u + 2 * v);
        f.pipeline->measure(depth);
        for (int i = 1; i < 5; ++i)
            f.track(wall(i));
        const DepthView result = f.track(wall(7)).depth;
        return std::vector(result.data(), result.data() + 320 * 240);
    };
    CHECK(run(1) == run(3));
}
