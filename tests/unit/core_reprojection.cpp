// SPDX-License-Identifier: Apache-2.0
#include "core/paper/reprojection.hpp"
#include "tests/catch.hpp"
#include "tests/matches.hpp"

#include <algorithm>
#include <random>

using namespace afterglow;

namespace {

const Intrinsics camera{100, 100, 32, 24, 64, 48};

DepthMap warp(const DepthMap &from, const Pose &pose, int workers = 1) {
    WorkerPool pool(workers);
    DepthMap to(from.width(), from.height());
    ForwardReprojection(camera, pool).warp(from, pose, to);
    return to;
}

DepthMap random_map() {
    DepthMap map(64, 48);
    std::mt19937 random(1);
    for (std::uint16_t &z : map.pixels())
        z = static_cast<std::uint16_t>(random());
    return map;
}

} // namespace

TEST_CASE("reprojection by the identity leaves every depth unchanged", "[core]") {
    const DepthMap map = random_map();
    CHECK(warp(map, Pose::identity()) == map);
}

TEST_CASE("reprojection towards a wall reduces its depth by the translation", "[core]") {
    const DepthMap moved =
        warp(DepthMap(64, 48, 2000), {Eigen::Matrix3d::Identity(), {0, 0, -0.5}});
    CHECK(std::ranges::all_of(moved.pixels(), [](int z) { return z == 0 || z == 1500; }));
    CHECK(moved(32, 24) == 1500);
}

TEST_CASE("reprojection sideways along a wall moves pixels by f T / z", "[core]") {
    DepthMap map(64, 48);
    map(20, 10) = 1000;
    const DepthMap moved = warp(map, {Eigen::Matrix3d::Identity(), {0.05, -0.02, 0}});
    CHECK(moved(25, 8) == 1000);
    CHECK(std::ranges::count(moved.pixels(), 0) == 64 * 48 - 1);
}

TEST_CASE("reprojection keeps the nearest of the points on a pixel", "[core]") {
    DepthMap map(64, 48);
    map(30, 20) = 1000;
    map(35, 20) = 2000;
    // The near point moves by 10 pixels, the far one by 5.
    const DepthMap moved = warp(map, {Eigen::Matrix3d::Identity(), {0.1, 0, 0}});
    CHECK(moved(40, 20) == 1000);
    CHECK(std::ranges::count(moved.pixels(), 0) == 64 * 48 - 1);
}

TEST_CASE("reprojection skips points behind the camera, out of view or out of range", "[core]") {
    const DepthMap map(64, 48, 1000);
    for (const Eigen::Vector3d &T :
         {Eigen::Vector3d(0, 0, -1), {0, 0, -2}, {5, 0, 0}, {0, 0, 65}}) {
        const DepthMap moved = warp(map, {Eigen::Matrix3d::Identity(), T});
        CHECK(std::ranges::all_of(moved.pixels(), [](int z) { return z == 0; }));
    }
}

TEST_CASE("reprojection is identical for any number of workers", "[core]") {
    const Pose pose{rotation({0.1, -0.2, 0.3}), {0.1, 0.2, -0.3}};
    const DepthMap one = warp(random_map(), pose, 1);
    CHECK(warp(random_map(), pose, 2) == one);
    CHECK(warp(random_map(), pose, 5) == one);
}
