// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe.hpp"
#include "tests/catch.hpp"

#include <cmath>

using namespace afterglow;

namespace {

const Intrinsics camera{260, 260, 159.5, 119.5, 320, 240};

/// A wall 2 m ahead.
DepthSurface wall(std::uint16_t mm = 2000) {
    const DepthMap map(camera.width, camera.height, mm);
    WorkerPool pool(1);
    DepthSurface surface(camera, SurfaceOptions{});
    surface.build(map, pool);
    return surface;
}

Pose shifted(const Eigen::Vector3d &by) {
    return {Eigen::Matrix3d::Identity(), by};
}

} // namespace

TEST_CASE("the mean displacement of a surface is the angle by which its points are seen elsewhere",
          "[core]") {
    CHECK(mean_displacement(wall(), camera, Pose::identity()) == Approx(0).margin(1e-6));
    CHECK(mean_displacement(wall(), camera, shifted({0.1, 0, 0})) == Approx(0.05));
    CHECK(mean_displacement(wall(), camera, shifted({0.03, 0.04, 0})) == Approx(0.025));
    const Pose turned = exp((Twist() << 0, 0, 0, 0, 0, 0.01).finished());
    CHECK(mean_displacement(wall(), camera, turned) < 0.01f); // about the axis: by its distance
    const Pose panned = exp((Twist() << 0, 0, 0, 0, 0.01, 0).finished());
    CHECK(mean_displacement(wall(), camera, panned) == Approx(0.01).epsilon(0.2));
}

TEST_CASE("the mean displacement is finite whatever the motion", "[core]") {
    CHECK(mean_displacement(wall(0), camera, shifted({0.1, 0, 0})) == 0.0f); // no depth
    CHECK(mean_displacement(wall(), camera, shifted({0, 0, -3})) == 0.0f);   // behind the camera
    CHECK(mean_displacement(wall(), camera, shifted({1e6, 0, 0})) == 1.0f);
}

TEST_CASE("the visible share of a surface is what the other camera has in its picture", "[core]") {
    CHECK(visible_share(wall(), camera, Pose::identity(), camera) == 1.0f);
    CHECK(visible_share(wall(0), camera, Pose::identity(), camera) == 0.0f);
    CHECK(visible_share(wall(), camera, shifted({0, 0, -3}), camera) == 0.0f);
    // By half the picture's width: 2 m * 160 px / 260 px.
    CHECK(visible_share(wall(), camera, shifted({1.23, 0, 0}), camera) == Approx(0.5));
}
