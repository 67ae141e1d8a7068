// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/depth_refinement.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

/// The synthetic room from one place, measured twice with noise of 0.5 % of the depth.
struct TwoMaps {
    Film film = film_room(320, 240, 1);
    DepthMap first = noisy(1), second = noisy(2);

    DepthMap noisy(unsigned seed) const {
        DepthMap depth = film.depth[0];
        std::mt19937 random(seed);
        std::normal_distribution<double> noise(1, 0.005);
        for (std::uint16_t &mm : depth.pixels())
            mm = static_cast<std::uint16_t>(std::lround(mm * noise(random)));
        return depth;
    }
    DepthFit fit(const Pose &start = Pose::identity()) const {
        WorkerPool pool(1);
        DepthSurface from(film.camera, SurfaceOptions{}), to(film.camera, SurfaceOptions{});
        from.build(first, pool);
        to.build(second, pool);
        return refine_by_depth(from, to, film.camera, start,
                               Eigen::Matrix<float, 6, 6>::Identity());
    }
};

} // namespace

TEST_CASE("depth refinement finds that two maps were measured from one place", "[core]") {
    const TwoMaps maps;
    const Pose start{Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                     {0.01, -0.02, 0.01}};
    const DepthFit fit = maps.fit(start);
    REQUIRE(fit.good);
    CHECK(fit.pose.T.norm() < 0.005);
    CHECK(fit.pose.angle() < 0.002);
    CHECK(fit.relative_error > 0.0005f); // noise, less what smoothing takes away
    CHECK(fit.relative_error < 0.005f);
}

TEST_CASE("depth refinement limits what a moved thing adds to the relative error of two maps",
          "[core]") {
    TwoMaps maps;
    const DepthFit before = maps.fit();
    // Something has come into a tenth of the second view.
    for (int v = 60; v < 150; ++v)
        for (int u = 110; u < 195; ++u)
            maps.second(u, v) = static_cast<std::uint16_t>(maps.second(u, v) * 0.6);
    const DepthFit after = maps.fit();
    REQUIRE(before.good);
    REQUIRE(after.good);
    CAPTURE(before.relative_error, after.relative_error);
    CHECK(after.relative_error > before.relative_error);
    CHECK(after.relative_error < 0.1f * 0.4f / 4); // of a tenth of the view by 40 %
}

TEST_CASE("depth refinement gives no relative error for a map without depth", "[core]") {
    TwoMaps maps;
    std::ranges::fill(maps.second.pixels(), std::uint16_t{0});
    const DepthFit fit = maps.fit();
    CHECK(!fit.good);
    CHECK(fit.relative_error == 0);
}

TEST_CASE("depth refinement gives the relative error of maps that do not fit", "[core]") {
    TwoMaps maps;
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            maps.second(u, v) =
                static_cast<std::uint16_t>(2000 + 700 * std::sin(0.04 * u) * std::cos(0.05 * v));
    const DepthFit fit = maps.fit();
    CHECK(!fit.good);
    CHECK(fit.relative_error > 0.02f);
}
