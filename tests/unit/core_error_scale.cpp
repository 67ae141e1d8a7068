// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <cmath>
#include <limits>
#include <random>

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("an error scale without readings is cautious: somewhat more than one", "[core]") {
    CHECK(ErrorScale().scale() > 1.2f);
    CHECK(ErrorScale().scale() < 1.6f);
}

TEST_CASE("an error scale finds a constant factor within three readings", "[core]") {
    for (const double factor : {0.2, 0.5, 2.0, 4.0}) {
        ErrorScale scale;
        for (int k = 0; k < 3; ++k)
            scale.learn(factor * 0.7, 0.7);
        INFO(factor);
        CHECK(scale.scale() > 0.9 * factor);
        CHECK(scale.scale() < 1.5 * factor);
    }
}

TEST_CASE("one wild reading moves a settled error scale by less than a factor of two", "[core]") {
    ErrorScale scale;
    for (int k = 0; k < 10; ++k)
        scale.learn(1, 1);
    const float before = scale.scale();
    scale.learn(1000, 1);
    CHECK(scale.scale() > before);
    CHECK(scale.scale() < 2 * before);
}

TEST_CASE("an error scale forgets: it follows a factor that has changed for good", "[core]") {
    ErrorScale scale;
    for (int k = 0; k < 50; ++k)
        scale.learn(0.5, 1);
    for (int k = 0; k < 10; ++k)
        scale.learn(3, 1);
    CHECK(scale.scale() == Approx(3).epsilon(0.25));
}

TEST_CASE("an error scale leaves out readings that are no errors", "[core]") {
    ErrorScale scale;
    const float before = scale.scale();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const auto &[truth, modelled] : {std::pair(0.0, 1.0),
                                          {1.0, 0.0},
                                          {-1.0, 1.0},
                                          {nan, 1.0},
                                          {1.0, nan},
                                          {infinity, 1.0},
                                          {1.0, infinity}})
        scale.learn(truth, modelled);
    CHECK(scale.scale() == before);
}

TEST_CASE("a sensor noisier than configured is found out within a few measurements", "[core]") {
    // Of the white noise in each map the configured sensor knows nothing.
    const double deviation = GENERATE(0.015, 0.03);
    INFO(deviation);
    Film scene = film_room(320, 240, 24, 0.5);
    std::mt19937 random(1);
    std::normal_distribution<double> noise(1, deviation);
    for (DepthMap &depth : scene.depth)
        for (std::uint16_t &z : depth.pixels())
            z = static_cast<std::uint16_t>(std::lround(z * noise(random)));
    Viewer viewer(scene);
    for (int k = 0; k <= 16; ++k) {
        viewer.track(k);
        if (k % 5 == 1)
            viewer.measure(k);
    }
    const Estimate &e = viewer.track(17);
    REQUIRE(e.source == FrameSource::estimated);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            if (const double truth = scene.depth[17](u, v); truth > 0 && e.depth(u, v) > 0) {
                sum += std::abs(e.depth(u, v) - truth) / truth;
                ++count;
            }
    const double true_mre = 100 * sum / count;
    CHECK(true_mre / e.expected_mre > 0.7);
    CHECK(true_mre / e.expected_mre < 1.4);
}
