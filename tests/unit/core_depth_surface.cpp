// SPDX-License-Identifier: Apache-2.0
#include "core/surface/depth_surface.hpp"
#include "core/surface/surface_point.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <random>

using namespace afterglow;

namespace {

const Intrinsics camera{100, 100, 49.5, 34.5, 100, 70};

DepthSurface surface_of(const DepthMap &map, const SurfaceOptions &options = {},
                        const DepthCorrection &calibration = {}, int workers = 1) {
    WorkerPool pool(workers);
    DepthSurface surface(camera, options);
    surface.build(map, pool, calibration);
    return surface;
}

/// 1 m to the left of column 50, 2 m from there on.
DepthMap step() {
    DepthMap map(camera.width, camera.height, std::uint16_t{1000});
    for (int v = 0; v < camera.height; ++v)
        for (int u = 50; u < camera.width; ++u)
            map(u, v) = 2000;
    return map;
}

} // namespace

TEST_CASE("the depth surface knows each pixel's distance to the nearest depth edge", "[core]") {
    const DepthSurface surface = surface_of(step());
    for (int u = 0; u < camera.width; ++u) {
        const int distance = u < 50 ? 50 - u : u - 49;
        CHECK(surface.edge_distance()(u, 35) == std::min(distance, far_from_edge));
    }
}

TEST_CASE("the depth surface sees no depth edge in a slope or around a hole", "[core]") {
    DepthMap map(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            map(u, v) = static_cast<std::uint16_t>(1000 + 10 * u);
    for (int v = 18; v < 22; ++v)
        for (int u = 30; u < 34; ++u)
            map(u, v) = 0;
    const DepthSurface surface = surface_of(map);
    for (int u = 0; u < camera.width; ++u)
        CHECK(surface.edge_distance()(u, 20) == far_from_edge);
    CHECK(surface.z()(31, 20) == 0.0f);
}

TEST_CASE("the depth surface fills cracks between parts of one surface", "[core]") {
    DepthMap map = step(); // between the columns 49 and 50
    for (int v = 10; v < 40; ++v) {
        map(20, v) = 0;              // a crack of one pixel,
        map(28, v) = map(29, v) = 0; // of two,
        map(35, v) = map(36, v) = map(37, v) = 0;
        map(70, v) = static_cast<std::uint16_t>(map(70, v) + 300); // a column behind it
    }
    for (const int crack_px : {0, 1, 2}) {
        SurfaceOptions options;
        options.smooth_radius_px = 0;
        options.crack_px = crack_px;
        DepthSurface surface(camera, options);
        WorkerPool pool(1);
        surface.build(map, pool);
        CAPTURE(crack_px);
        const float left = 0.001f * map(21, 20), right = 0.001f * map(60, 20);
        CHECK((surface.z()(20, 20) != 0.0f) == (crack_px >= 1));
        CHECK((surface.z()(28, 20) != 0.0f) == (crack_px >= 2));
        CHECK((surface.z()(29, 20) != 0.0f) == (crack_px >= 2));
        CHECK(surface.z()(36, 20) == 0.0f);
        if (crack_px >= 1) {
            CHECK(surface.z()(20, 20) == Approx(left));
            CHECK(edge_distance_of(surface.z()(20, 20)) == beside_edge);
        }
        // Three columns are on edges there.
        CHECK(surface.z()(70, 20) == Approx(0.001f * map(70, 20)));
        // What parts two surfaces stays.
        for (const int u : {49, 50})
            CHECK(edge_distance_of(surface.z()(u, 20)) == 1);
        CHECK(surface.z()(49, 20) == Approx(left));
        CHECK(surface.z()(50, 20) == Approx(right));
    }
}

TEST_CASE("a depth surface that is read and then finished is the one that is built", "[core]") {
    DepthMap map = step();
    for (int v = 10; v < 40; ++v)
        map(20, v) = 0;
    const DepthSurface built = surface_of(map);
    DepthSurface parts(camera, {});
    WorkerPool pool(1);
    parts.read(map, pool);
    CHECK(parts.z()(20, 20) == 0.0f);
    CHECK(parts.z()(60, 20) == built.z()(60, 20));
    for (int again = 0; again < 2; ++again) {
        parts.finish();
        for (int v = 0; v < camera.height; ++v)
            CHECK(std::equal(parts.z().row(v), parts.z().row(v) + camera.width, built.z().row(v)));
        CHECK(parts.pieces().nearest()(5, 3) == built.pieces().nearest()(5, 3));
    }
}

TEST_CASE("depth smoothing removes noise but does not cross depth edges", "[core]") {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 4);
    DepthMap map = step();
    for (std::uint16_t &mm : map.pixels())
        mm = static_cast<std::uint16_t>(std::lround(mm + noise(random)));
    const DepthSurface surface = surface_of(map);
    double before = 0, after = 0;
    for (int v = 5; v < 65; ++v)
        for (int u = 52; u < 95; ++u) {
            before += std::pow(0.001 * map(u, v) - 2, 2);
            after += std::pow(surface.z()(u, v) - 2.0f, 2);
        }
    CHECK(after < 0.2 * before);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            REQUIRE(surface.z()(u, v) == Approx(u < 50 ? 1 : 2).margin(0.03));
}

TEST_CASE("depth smoothing averages readings over five rows and columns", "[core]") {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 2);
    for (const int block : {1, 2}) { // pixels wide and high, of one noise
        DepthMap map(camera.width, camera.height);
        for (int v = 0; v < camera.height; v += block)
            for (int u = 0; u < camera.width; u += block) {
                const auto mm = static_cast<std::uint16_t>(std::lround(2000 + noise(random)));
                for (int i = 0; i < block * block; ++i)
                    map(u + i % block, v + i / block) = mm;
            }
        const DepthSurface surface = surface_of(map);
        for (int v = 10; v < 60; v += 7)
            for (int u = 10; u < 90; u += 7) {
                double sum = 0;
                for (int dv = -2; dv <= 2; ++dv)
                    for (int du = -2; du <= 2; ++du)
                        sum += 0.001 * map(u + du, v + dv);
                CAPTURE(block, u, v);
                // Means of pairs, of rows and of columns are rounded to half a millimetre.
                CHECK(surface.z()(u, v) == Approx(sum / 25).margin(7e-4));
            }
    }
}

TEST_CASE("depth smoothing uses narrow windows where a surface is bent, and wide ones elsewhere",
          "[core]") {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 3);
    DepthMap roof(camera.width, camera.height); // with its ridge in column 50
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            roof(u, v) = static_cast<std::uint16_t>(
                std::lround(2000 + 7 * std::abs(u - 50) + noise(random)));
    const bool with_amplitude = GENERATE(false, true);
    const Image<std::uint16_t> amplitude(camera.width, camera.height, std::uint16_t{1000});
    struct Errors {
        double ridge = 0, plane = 0; ///< mean, millimetres; root mean square
    };
    const auto errors_of = [&](const SurfaceOptions &options) {
        WorkerPool pool(2);
        DepthSurface surface(camera, options);
        for (int again = 0; again < 2; ++again) // nothing of the last map is left
            surface.build(again == 0 ? step() : roof, pool, {},
                          with_amplitude ? amplitude.view() : ImageView<const std::uint16_t>{});
        Errors errors;
        int count = 0;
        for (int v = 6; v < camera.height - 6; ++v) {
            errors.ridge += 1000 * surface.z()(50, v) - 2000;
            for (int u = 6; u < camera.width - 6; ++u) {
                if (std::abs(u - 50) < 8)
                    continue;
                errors.plane +=
                    std::pow(1000 * surface.z()(u, v) - (2000 + 7 * std::abs(u - 50)), 2);
                ++count;
            }
        }
        errors.ridge /= camera.height - 12;
        errors.plane = std::sqrt(errors.plane / count);
        return errors;
    };
    SurfaceOptions keeping, small;
    keeping.keep_creases = true;
    small.smooth_radius_px = 1;
    const Errors wide = errors_of({}), kept = errors_of(keeping), narrow = errors_of(small);
    CAPTURE(wide.ridge, kept.ridge, narrow.ridge, wide.plane, kept.plane, narrow.plane);
    CHECK(wide.ridge > 7);
    CHECK(kept.ridge < 0.7 * wide.ridge);
    CHECK(kept.ridge < narrow.ridge + 0.5);
    CHECK(kept.plane < 1.1 * wide.plane);
    CHECK(kept.plane < 0.8 * narrow.plane);
}

TEST_CASE("the depth surface ignores invalid pixels", "[core]") {
    DepthMap map(camera.width, camera.height, std::uint16_t{1000});
    for (int v = 0; v < camera.height; ++v) {
        map(0, v) = 0;
        map(1, v) = 50;    // nearer than nearest_m
        map(2, v) = 20000; // further than farthest_m
    }
    const DepthSurface surface = surface_of(map);
    for (int u = 0; u < 3; ++u)
        CHECK(surface.z()(u, 35) == 0.0f);
}

TEST_CASE("the depth surface applies the depth correction", "[core]") {
    DepthCorrection calibration;
    calibration.shape = {0.1f, -0.05f, 0.02f};
    const DepthSurface surface =
        surface_of(DepthMap(camera.width, camera.height, std::uint16_t{1000}), {}, calibration);
    for (const auto &[u, v] : {std::pair(10, 20), std::pair(80, 60)}) {
        const double x = (u - camera.cx) / camera.fx, y = (v - camera.cy) / camera.fy;
        const double expected = 1 + 0.1 * x - 0.05 * y + 0.02 * (x * x + y * y);
        CHECK(surface.z()(u, v) == Approx(expected).margin(1e-3));
    }
}

TEST_CASE("readings of little light count less in depth smoothing", "[core]") {
    // A wall with dark and bright stripes, whose readings are 1 mm noisy at an amplitude of 4000.
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 1);
    Image<std::uint16_t> amplitude(camera.width, camera.height);
    DepthMap map(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
            amplitude(u, v) = u / 3 % 2 == 0 ? 4000 : 400;
            map(u, v) = static_cast<std::uint16_t>(
                std::lround(2000 + 4000.0 / amplitude(u, v) * noise(random)));
        }
    WorkerPool pool(2);
    DepthSurface surface(camera, {});
    const auto error_mm = [&](ImageView<const std::uint16_t> known) {
        surface.build(map, pool, {}, known);
        double sum = 0;
        for (int v = 3; v < camera.height - 3; ++v)
            for (int u = 3; u < camera.width - 3; ++u)
                sum += std::pow(1000 * surface.z()(u, v) - 2000, 2);
        return std::sqrt(sum / ((camera.width - 6) * (camera.height - 6)));
    };
    const double alike = error_mm({}), weighted = error_mm(amplitude);
    INFO(alike << " mm, weighted " << weighted << " mm");
    CHECK(weighted < 0.5 * alike);
    // Where all is equally bright it is smoothed as well as in two passes, but for outliers.
    std::ranges::fill(amplitude.pixels(), std::uint16_t{700});
    CHECK(error_mm(amplitude) < 1.3 * alike);
    CHECK(error_mm(amplitude) > 0.8 * alike);
}

TEST_CASE("a dim surface keeps its depth beside a bright one", "[core]") {
    const DepthMap map = step();
    Image<std::uint16_t> amplitude(camera.width, camera.height, std::uint16_t{100});
    for (int v = 0; v < camera.height; ++v)
        for (int u = 50; u < camera.width; ++u)
            amplitude(u, v) = 60000;
    amplitude(20, 20) = 0; // no light, and depth all the same
    WorkerPool pool(1);
    DepthSurface surface(camera, {});
    surface.build(map, pool, {}, amplitude);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            REQUIRE(surface.z()(u, v) == Approx(u < 50 ? 1 : 2).margin(1e-5));
}

TEST_CASE("the depth surface finds out how noisy its map is", "[core]") {
    std::mt19937 random(1);
    DepthMap map(camera.width, camera.height);
    const double deviation = GENERATE(0.0, 0.001, 0.01, 0.03);
    INFO(deviation);
    std::normal_distribution<double> noise(1, deviation);
    for (int v = 0; v < camera.height; ++v) // a slope and an edge are no noise
        for (int u = 0; u < camera.width; ++u)
            map(u, v) = static_cast<std::uint16_t>(
                std::lround(((u < 30 ? 1800 : 1980) + v) * noise(random)));
    const SensorNoise configured = SurfaceOptions{}.noise;
    const DepthSurface surface = surface_of(map);
    const double expected = std::max<double>(configured.sigma(2), 2 * deviation);
    CHECK(surface.noise().sigma(2) == Approx(expected).epsilon(0.25));
}

TEST_CASE("the depth surface is identical for any number of workers", "[core]") {
    const DepthSurface one = surface_of(step()), three = surface_of(step(), {}, {}, 3);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            REQUIRE(one.z()(u, v) == three.z()(u, v));
}
