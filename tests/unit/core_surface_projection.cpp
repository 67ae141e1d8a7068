// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_projection.hpp"
#include "tests/catch.hpp"

#include <random>

using namespace afterglow;

TEST_CASE("points that a pixel of the view shows are projected to it", "[core]") {
    const Intrinsics from{310, 305, 161, 118, 320, 240}, to{525, 520, 318, 244, 640, 480};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> some(-1, 1);
    for (int round = 0; round < 200; ++round) {
        const auto vector = [&](double size) -> Eigen::Vector3d {
            return size * Eigen::Vector3d(some(random), some(random), some(random));
        };
        RollingShutter shutter;
        double shift_m = 0.3;
        float tolerance_px = 0.005f;
        if (round % 3 == 1) { // along parallax a skew is that of points infinitely far away
            shutter.skew = vector(0.01).cast<float>();
            shift_m = 0.05;
            tolerance_px = 0.2f;
        } else if (round % 3 == 2) { // projected by the row on which a point was before it moved
            shutter.motion << vector(0.005), vector(0.005);
            tolerance_px = 0.15f;
        }
        const Pose pose{rotation(vector(0.15)), vector(shift_m)};
        const SurfaceProjection projection(from, to, pose, shutter);
        for (int y = 0; y <= to.height; y += 120) {
            const ViewRow row = projection.view_row(static_cast<float>(y));
            for (int x = 0; x <= to.width; x += 128) {
                const ViewRay ray = row.at(static_cast<float>(x));
                for (const float z : {0.8f, 1.5f, 6.0f}) {
                    const Eigen::Vector2f place = ray.place(z);
                    const Eigen::Vector3f seen = projection(place.x(), place.y(), z);
                    CAPTURE(round, x, y, z, seen);
                    REQUIRE(std::abs(seen.x() - static_cast<float>(x)) < tolerance_px);
                    REQUIRE(std::abs(seen.y() - static_cast<float>(y)) < tolerance_px);
                    REQUIRE(std::abs(seen.z() - ray.depth(z)) < 1e-3f * seen.z());
                }
            }
        }
    }
}
