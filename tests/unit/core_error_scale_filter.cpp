// SPDX-License-Identifier: Apache-2.0
#include "core/error/error_scale_filter.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr double fresh = 0.4, carried = 0.6; // as modelled

/// The readings of a measurement if the true factors are `of_fresh` and `of_carried`.
void learn(ErrorScaleFilter &filter, double of_fresh, double of_carried) {
    filter.learn_fresh(of_fresh * fresh, fresh);
    filter.learn_carried(std::hypot(of_fresh * fresh, of_carried * carried), fresh, carried);
}

double ratio(const ErrorScales &now, const ErrorScales &before) {
    return std::max(now.fresh / before.fresh, now.carried / before.carried);
}

} // namespace

TEST_CASE("the filter of error factors begins with a mean above one", "[core]") {
    const ErrorScales scales = ErrorScaleFilter().scales();
    CHECK(scales.fresh == Approx(std::exp(0.8 * 0.8 / 2))); // the prior deviation is 0.8
    CHECK(scales.carried == scales.fresh);
}

TEST_CASE("the filter of error factors finds that of a fresh map within three readings", "[core]") {
    for (const double factor : {0.2, 0.5, 2.0, 4.0}) {
        ErrorScaleFilter filter;
        for (int k = 0; k < 3; ++k)
            filter.learn_fresh(factor * fresh, fresh);
        INFO(factor);
        CHECK(filter.scales().fresh > 0.9 * factor);
        CHECK(filter.scales().fresh < 1.5 * factor);
    }
}

TEST_CASE("the filter of error factors tells both apart after 15 measurements", "[core]") {
    const auto [of_fresh, of_carried] = GENERATE(std::pair(1.0, 1.0), std::pair(0.4, 1.5),
                                                 std::pair(2.5, 0.7), std::pair(4.0, 3.0));
    ErrorScaleFilter filter;
    for (int k = 0; k < 15; ++k)
        learn(filter, of_fresh, of_carried);
    const ErrorScales scales = filter.scales();
    CAPTURE(of_fresh, of_carried, scales.fresh, scales.carried);
    CHECK(scales.fresh == Approx(of_fresh).epsilon(0.2));
    // Its readings have more than twice the noise.
    CHECK(scales.carried > 0.7 * of_carried);
    CHECK(scales.carried < 1.8 * of_carried);
}

TEST_CASE("the filter of error factors corrects the factor of the larger part of an error",
          "[core]") {
    const ErrorScales before = ErrorScaleFilter().scales();
    ErrorScaleFilter at_rest, moving;
    at_rest.learn_carried(2, 1, 0.1);
    moving.learn_carried(2, 0.1, 1);
    CHECK(at_rest.scales().fresh > 1.05f * before.fresh);
    CHECK(at_rest.scales().carried == Approx(before.carried).epsilon(0.05));
    CHECK(moving.scales().carried > 1.05f * before.carried);
    CHECK(moving.scales().fresh == Approx(before.fresh).epsilon(0.05));
    at_rest.learn_carried(2, 1, 0); // carrying the map added nothing
    CHECK(std::isfinite(at_rest.scales().carried));
}

TEST_CASE("one wild reading moves settled error factors by less than a factor of two", "[core]") {
    const double wild = GENERATE(1000.0, 0.001);
    const bool of_fresh = GENERATE(false, true);
    ErrorScaleFilter filter;
    for (int k = 0; k < 10; ++k)
        learn(filter, 1, 1);
    const ErrorScales before = filter.scales();
    if (of_fresh)
        filter.learn_fresh(wild * fresh, fresh);
    else
        filter.learn_carried(wild * std::hypot(fresh, carried), fresh, carried);
    CAPTURE(wild, of_fresh);
    CHECK(ratio(filter.scales(), before) < 2);
    CHECK(ratio(before, filter.scales()) < 2);
    CHECK_FALSE(filter.scales() == before);
}

TEST_CASE("the filter of error factors follows a lasting change", "[core]") {
    ErrorScaleFilter filter;
    for (int k = 0; k < 50; ++k)
        learn(filter, 0.5, 1);
    for (int k = 0; k < 10; ++k)
        learn(filter, 3, 1);
    CHECK(filter.scales().fresh == Approx(3).epsilon(0.25));
}

// As with a camera that is measured in every frame, or with one that never moves.
TEST_CASE("an error factor without readings stays at its prior", "[core]") {
    const bool measured_always = GENERATE(false, true);
    ErrorScaleFilter filter;
    const ErrorScales before = filter.scales();
    for (int k = 0; k < 1000; ++k)
        if (measured_always)
            filter.learn_fresh(fresh, fresh);
        else
            filter.learn_carried(fresh, fresh, 1e-6);
    CHECK(filter.scales().carried == Approx(before.carried).epsilon(0.01));
    CHECK(filter.scales().fresh == Approx(1).epsilon(0.3));
}

TEST_CASE("the filter of error factors ignores errors that are not positive and finite", "[core]") {
    ErrorScaleFilter filter;
    const ErrorScales before = filter.scales();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {0.0, -1.0, nan, infinity}) {
        filter.learn_fresh(bad, fresh);
        filter.learn_fresh(fresh, bad);
        filter.learn_carried(bad, fresh, carried);
        filter.learn_carried(fresh, bad, carried);
        if (bad != 0) // carrying a map may add nothing
            filter.learn_carried(fresh, fresh, bad);
    }
    CHECK(filter.scales() == before);
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
