// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/depth_edges.hpp"
#include "tests/catch.hpp"

#include <cmath>

using namespace afterglow;

namespace {

const Intrinsics camera{100, 100, 49.5, 34.5, 100, 70};
constexpr int left = 30, right = 69, top = 20, bottom = 49; ///< of a box, inclusive

/// A box at 1 m before a wall at 2 m; `shadow` columns to its left have no reading.
DepthMap box(int shadow = 0) {
    DepthMap map(camera.width, camera.height, std::uint16_t{2000});
    for (int v = top; v <= bottom; ++v)
        for (int u = left - shadow; u <= right; ++u)
            map(u, v) = u < left ? 0 : 1000;
    return map;
}

DepthSurface surface_of(const DepthMap &map) {
    WorkerPool pool(1);
    DepthSurface surface(camera, {});
    surface.build(map, pool);
    return surface;
}

} // namespace

TEST_CASE("depth edges lie on the margin of the near surface and point away from it", "[core]") {
    const int shadow = GENERATE(0, 3);
    DepthEdges finder(1000);
    const auto edges = finder.find(surface_of(box(shadow)), camera, Pose::identity());
    REQUIRE(edges.size() > 80); // the margin has 136 pixels
    int of_side[4] = {};
    for (const DepthEdge &edge : edges) {
        CHECK(edge.at.z() == Approx(1).margin(0.01));
        const Eigen::Vector2d at = camera.project(edge.at.cast<double>());
        const Eigen::Vector2d out = camera.project(edge.beyond.cast<double>()) - at;
        CHECK(out.norm() == Approx(3).margin(0.01));
        const double off[4] = {left - 0.5 - at.x(), at.x() - right - 0.5, top - 0.5 - at.y(),
                               at.y() - bottom - 0.5};
        const double along[4] = {-out.x(), out.x(), -out.y(), out.y()};
        for (int side = 0; side < 4; ++side)
            if (along[side] > 2.9) {
                CHECK(std::abs(off[side]) < 0.2);
                ++of_side[side];
            }
    }
    for (const int found : of_side)
        CHECK(found > 15);
}

TEST_CASE("depth edges are given in the frame of another camera", "[core]") {
    const DepthSurface surface = surface_of(box());
    const Pose pose{rotation({0.1, -0.2, 0.3}), {0.01, 0.02, -0.03}};
    DepthEdges here(1000), there(1000);
    const auto a = here.find(surface, camera, Pose::identity());
    const auto b = there.find(surface, camera, pose);
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        CHECK((pose * a[i].at.cast<double>() - b[i].at.cast<double>()).norm() < 1e-5);
}

TEST_CASE("of too many depth edges some of all sides are kept", "[core]") {
    DepthEdges finder(20);
    const auto edges = finder.find(surface_of(box()), camera, Pose::identity());
    REQUIRE(edges.size() == 20);
    int left_half = 0, upper_half = 0;
    for (const DepthEdge &edge : edges) {
        left_half += edge.at.x() < 0;
        upper_half += edge.at.y() < 0;
    }
    CHECK(left_half > 4);
    CHECK(left_half < 16);
    CHECK(upper_half > 4);
    CHECK(upper_half < 16);
}

TEST_CASE("a slope, a spike and a map without readings have no depth edges", "[core]") {
    DepthMap slope(camera.width, camera.height), spike(camera.width, camera.height, 2000);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            slope(u, v) = static_cast<std::uint16_t>(1000 + 15 * u);
    spike(50, 35) = 1000;
    DepthEdges finder(100);
    for (const DepthMap &map : {slope, spike, DepthMap(camera.width, camera.height)})
        CHECK(finder.find(surface_of(map), camera, Pose::identity()).empty());
}
