// SPDX-License-Identifier: Apache-2.0
// Kernels of the tiles' corners against the scalar code that they stand for.
#include "core/surface/depth_surface.hpp"
#include "core/warp/corner_kernels.hpp"
#include "core/warp/mapped_tile.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace afterglow;

namespace {

constexpr Intrinsics camera{300, 300, 159.5, 119.5, 320, 240};
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

/// A slope with a step across it, single readings that are missing, and a hole that is too large to
/// see around; nothing at the right.
DepthMap broken_slope() {
    DepthMap map(camera.width, camera.height);
    std::mt19937 random(5);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
            const bool hole = (u > 100 && u < 200 && v > 60 && v < 160) || u > 300;
            if (!hole && random() % 9 != 0)
                map(u, v) = static_cast<std::uint16_t>((v < 50 ? 900 : 2000) + 3 * u);
        }
    return map;
}

/// Rays with an array for each value.
struct Rays {
    explicit Rays(std::size_t count) {
        for (std::vector<float> &value : values)
            value.resize(count);
    }
    ViewRays view() {
        return {values[0].data(), values[1].data(), values[2].data(),
                values[3].data(), values[4].data(), values[5].data()};
    }
    std::array<std::vector<float>, 6> values;
};

/// Rays that meet the surface anywhere, or beside it, and some that are not even numbers.
Rays any_rays(std::mt19937 &random, std::size_t count) {
    std::uniform_real_distribution<float> u(-40, 360), v(-40, 280), parallax(-60, 60);
    std::uniform_real_distribution<float> scale(0.8f, 1.2f), shift(-0.3f, 0.3f);
    Rays rays(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::array<float, 6> one{u(random),        v(random),     parallax(random),
                                       parallax(random), scale(random), shift(random)};
        for (std::size_t k = 0; k < one.size(); ++k)
            rays.values[k][i] = random() % 50 == 0 ? (random() % 2 == 0 ? nan : infinity) : one[k];
    }
    return rays;
}

bool is_near(float a, float b) {
    return std::abs(a - b) <= 1e-5f * std::abs(b) + 1e-4f;
}

/// Depth at a place, as find_corners() takes it; 0: none.
float depth_near(const DepthSurface &surface, float u, float v) {
    constexpr float beside = mapped_tile_px;
    const float right = camera.width - 1, bottom = camera.height - 1;
    if (!(u > -beside && v > -beside && u < right + beside && v < bottom + beside))
        return 0;
    const int x = static_cast<int>(std::clamp(u, 0.0f, right) + 0.5f);
    const int y = static_cast<int>(std::clamp(v, 0.0f, bottom) + 0.5f);
    const float z = surface.z()(x, y);
    return z != 0 ? z : surface.pieces().nearest_around(x, y);
}

} // namespace

TEST_CASE("corners of tiles are found in vectors as one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    WorkerPool alone(1);
    SurfaceOptions options;
    options.smooth_radius_px = 0;
    DepthSurface surface(camera, options);
    surface.build(broken_slope(), alone);
    const CornerSearch search = {surface.z(), surface.pieces(), options.nearest_m,
                                 options.farthest_m};
    std::mt19937 random(6);
    int found = 0, none = 0, borderline = 0;
    for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{41}})
        for (int round = 0; round < 200; ++round) {
            Rays rays = any_rays(random, count);
            std::vector<float> first(count), units(count);
            for (std::size_t i = 0; i < count; ++i) {
                first[i] =
                    random() % 5 == 0 ? 0 : 0.8f + 0.002f * static_cast<float>(random() % 999);
                units[i] = 990 + static_cast<float>(random() % 20);
            }
            Rays to(count);
            find_corners(search, rays.view(), first.data(), units.data(), static_cast<int>(count),
                         {to.values[0].data(), to.values[1].data(), to.values[2].data(),
                          to.values[3].data(), to.values[4].data()});
            for (std::size_t i = 0; i < count; ++i) {
                const auto value = [&](std::size_t k) { return rays.values[k][i]; };
                const auto place = [&](float z) {
                    return Eigen::Vector2f(value(0) + value(2) / z, value(1) + value(3) / z);
                };
                float z = first[i];
                bool near_a_limit = false; // rounding decides
                for (int k = 0; k < 3 && z != 0; ++k) {
                    const Eigen::Vector2f before = place(z);
                    for (const float at : {before.x(), before.y()})
                        near_a_limit |= std::abs(at - std::floor(at) - 0.5f) < 1e-3f;
                    z = depth_near(surface, before.x(), before.y());
                    const float moved = (place(z) - before).norm();
                    near_a_limit |= std::abs(moved - 0.03f) < 1e-3f;
                    if (z != 0 && moved < 0.03f)
                        break;
                }
                const float depth = value(4) * z + value(5);
                if (!(depth >= options.nearest_m && depth <= options.farthest_m))
                    z = 0;
                if (near_a_limit) {
                    ++borderline;
                    continue;
                }
                CAPTURE(count, round, i);
                REQUIRE(to.values[2][i] == z);
                if (z == 0) {
                    ++none;
                    continue;
                }
                ++found;
                REQUIRE(is_near(to.values[0][i], place(z).x()));
                REQUIRE(is_near(to.values[1][i], place(z).y()));
                REQUIRE(is_near(to.values[3][i], units[i] * value(4)));
                REQUIRE(is_near(to.values[4][i], units[i] * value(5)));
            }
        }
    CHECK(found > 3000);
    CHECK(none > 2000);
    CHECK(borderline < 500);
}

TEST_CASE("parallax on tiles is found in vectors as one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> any(-1, 1);
    constexpr int count = 41;
    Rays rays(count), across(count);
    std::vector<float> nearest(count), farthest(count), pixels(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 4; ++k) {
            rays.values[k][i] = 100 * any(random);
            across.values[k][i] = rays.values[k][i] + (k < 2 ? 16 + any(random) : any(random));
        }
        nearest[i] = 1.5f + any(random);
        farthest[i] = nearest[i] + 1 + any(random);
    }
    find_parallax({rays.view(), across.view(), nearest.data(), farthest.data(), count},
                  pixels.data());
    for (std::size_t i = 0; i < count; ++i) {
        const auto place = [&](const Rays &of) {
            return Eigen::Vector2f(of.values[0][i] + of.values[2][i] / nearest[i],
                                   of.values[1][i] + of.values[3][i] / nearest[i]);
        };
        const float moved =
            (1 / nearest[i] - 1 / farthest[i]) * std::hypot(rays.values[2][i], rays.values[3][i]);
        const float diagonal = (place(across) - place(rays)).norm();
        CAPTURE(i);
        CHECK(pixels[i] == Approx(moved * std::sqrt(2.0f) * mapped_tile_px / diagonal));
    }
}
