// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

ErrorScale unlearnt() {
    return ErrorScale(0.45);
}

} // namespace

TEST_CASE("an error scale without readings is cautious: somewhat more than one", "[core]") {
    CHECK(unlearnt().scale() == Approx(std::exp(0.6 * 0.6 / 2))); // its prior deviation is 0.6
}

TEST_CASE("an error scale finds a constant factor within three readings", "[core]") {
    for (const double factor : {0.2, 0.5, 2.0, 4.0}) {
        ErrorScale scale = unlearnt();
        for (int k = 0; k < 3; ++k)
            scale.learn(factor * 0.7, 0.7);
        INFO(factor);
        CHECK(scale.scale() > 0.9 * factor);
        CHECK(scale.scale() < 1.5 * factor);
    }
}

TEST_CASE("an error scale learns less of a reading that is hardly about its error", "[core]") {
    ErrorScale all = unlearnt(), part = unlearnt(), hardly = unlearnt();
    all.learn(3, 1);
    part.learn(3, 1, 0.5);
    hardly.learn(3, 1, 0);
    CHECK(all.scale() > part.scale());
    CHECK(part.scale() > hardly.scale());
    CHECK(hardly.scale() == Approx(unlearnt().scale()).epsilon(0.1));
}

TEST_CASE("one wild reading moves a settled error scale by less than a factor of two", "[core]") {
    ErrorScale scale = unlearnt();
    for (int k = 0; k < 10; ++k)
        scale.learn(1, 1);
    const float before = scale.scale();
    scale.learn(1000, 1);
    CHECK(scale.scale() > before);
    CHECK(scale.scale() < 2 * before);
}

TEST_CASE("an error scale forgets: it follows a factor that has changed for good", "[core]") {
    ErrorScale scale = unlearnt();
    for (int k = 0; k < 50; ++k)
        scale.learn(0.5, 1);
    for (int k = 0; k < 10; ++k)
        scale.learn(3, 1);
    CHECK(scale.scale() == Approx(3).epsilon(0.25));
}

TEST_CASE("an error scale leaves out readings that are no errors", "[core]") {
    ErrorScale scale = unlearnt();
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

namespace {

/// Of the frames after the fourth measurement the median of true / announced error is near one.
void check_announced(Film &scene) {
    Viewer viewer(scene);
    for (int k = 0; k <= 16; ++k) {
        viewer.track(k);
        if (k % 5 == 1)
            viewer.measure(k);
    }
    std::vector<double> ratios;
    for (int k = 17; k <= 21; ++k) {
        const Estimate &e = viewer.track(k);
        REQUIRE(e.source == FrameSource::estimated);
        const DepthMap &truth = scene.depth[static_cast<std::size_t>(k)];
        ratios.push_back(compare_depth(e.depth, truth).mre / e.expected_mre);
        UNSCOPED_INFO("true " << compare_depth(e.depth, truth).mre << " %, announced "
                              << e.expected_mre << " %");
    }
    std::ranges::sort(ratios);
    CHECK(ratios[2] > 0.7);
    CHECK(ratios[2] < 1.4);
}

} // namespace

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
    check_announced(scene);
}

// Smooth maps that are each wrong in another way: neighbours tell nothing of it.
TEST_CASE("a sensor whose maps are each bent otherwise is found out within a few measurements",
          "[core]") {
    const double bend = GENERATE(0.02, 0.04);
    INFO(bend);
    Film scene = film_room(320, 240, 24, 0.5);
    for (std::size_t k = 0; k < scene.depth.size(); ++k)
        for (int v = 0; v < 240; ++v)
            for (int u = 0; u < 320; ++u) {
                const double wave =
                    std::sin(0.05 * u + 2.1 * double(k)) * std::cos(0.05 * v - 1.3 * double(k));
                std::uint16_t &z = scene.depth[k](u, v);
                z = static_cast<std::uint16_t>(std::lround(z * (1 + bend * wave)));
            }
    check_announced(scene);
}
