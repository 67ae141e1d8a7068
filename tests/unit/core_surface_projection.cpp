// SPDX-License-Identifier: Apache-2.0
#include "core/warp/surface_projection.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <random>

using namespace afterglow;

TEST_CASE("points that a pixel of the view shows are projected to it", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const Intrinsics from{310, 305, 161, 118, 320, 240}, to{525, 520, 318, 244, 640, 480};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> some(-1, 1);
    for (int round = 0; round < 200; ++round) {
        const auto vector = [&](double size) -> Eigen::Vector3d {
            // One by one: compilers differ in the order of a call's arguments.
            const double z = some(random), y = some(random), x = some(random);
            return size * Eigen::Vector3d(x, y, z);
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
            constexpr int step = 128, count = 6;
            float values[6][count];
            const ViewRays rays = {values[0], values[1], values[2],
                                   values[3], values[4], values[5]};
            find_view_rays(row, step, count, rays);
            for (int i = 0; i < count; ++i)
                for (const float z : {0.8f, 1.5f, 6.0f}) {
                    const Eigen::Vector3f seen =
                        projection(rays.infinite_u[i] + rays.parallax_u[i] / z,
                                   rays.infinite_v[i] + rays.parallax_v[i] / z, z);
                    CAPTURE(round, i, y, z, seen);
                    REQUIRE(std::abs(seen.x() - static_cast<float>(step * i)) < tolerance_px);
                    REQUIRE(std::abs(seen.y() - static_cast<float>(y)) < tolerance_px);
                    REQUIRE(std::abs(seen.z() - (rays.scale[i] * z + rays.shift[i])) <
                            1e-3f * seen.z());
                }
        }
    }
}
