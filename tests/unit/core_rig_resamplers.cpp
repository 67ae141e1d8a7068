// SPDX-License-Identifier: Apache-2.0
#include "core/rig/depth_resampler.hpp"
#include "core/rig/luma_resampler.hpp"
#include "core/rig/working_views.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

using namespace afterglow;

namespace {

const CameraModel fisheye{.pinhole = {340, 340, 322, 176, 640, 360},
                          .lens = Lens::kannala_brandt,
                          .distortion = {-0.02, 0.003, -0.001, 0.0002}};
const CameraModel barrel{.pinhole = {186, 188, 110, 87, 224, 172},
                         .lens = Lens::brown_conrady,
                         .distortion = {-0.25, 0.07, 0.001, -0.0008, 0.004}};

CameraModel pinhole(const Intrinsics &camera) {
    return {.pinhole = camera};
}

/// What is seen along the ray (x, y, 1): smooth, and different everywhere.
double shade(const Eigen::Vector2d &ray) {
    return 128 + 60 * std::sin(4 * ray.x() + 1) + 50 * std::cos(5 * ray.y());
}

/// Depth along Z of the plane n . X = 1, millimetres.
double plane_mm(const Eigen::Vector2d &ray) {
    return 1000 / Eigen::Vector3d(0.1, -0.05, 0.45).dot(ray.homogeneous());
}

template <class Pixel, class Value>
Image<Pixel> seen_by(const CameraModel &camera, const Value &value) {
    Image<Pixel> image(camera.pinhole.width, camera.pinhole.height);
    for (int v = 0; v < image.height(); ++v)
        for (int u = 0; u < image.width(); ++u)
            if (const auto ray = camera.ray(u, v))
                image(u, v) = static_cast<Pixel>(std::lround(value(*ray)));
    return image;
}

Eigen::Vector2d ray_of(const Intrinsics &camera, int u, int v) {
    return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy};
}

} // namespace

TEST_CASE("an image is shown without its lens") {
    const Intrinsics to{300, 300, 159.5, 119.5, 320, 240};
    const Luma image = seen_by<std::uint8_t>(fisheye, shade);
    LumaResampler resampler(fisheye, to);
    const std::uint64_t allocations = allocation_count();
    const LumaView seen = resampler.run(image);
    CHECK(allocation_count() == allocations);
    int checked = 0;
    double worst = 0;
    for (int v = 0; v < to.height; ++v)
        for (int u = 0; u < to.width; ++u, ++checked)
            worst = std::max(worst, std::abs(seen(u, v) - shade(ray_of(to, u, v))));
    CHECK(checked == 320 * 240);
    CHECK(worst < 2);
}

TEST_CASE("an image that is much finer is halved before it is shown") {
    CameraModel fine = barrel;
    fine.pinhole = {1860, 1880, 1104, 872, 2240, 1720};
    // Stripes of one pixel: what is only sampled would show them.
    Luma stripes(2240, 1720);
    for (int v = 0; v < stripes.height(); ++v)
        for (int u = 0; u < stripes.width(); ++u)
            stripes(u, v) = u % 2 ? 200 : 100;
    LumaResampler resampler(fine, {300, 300, 79.5, 59.5, 160, 120});
    const LumaView seen = resampler.run(stripes);
    for (int v = 0; v < seen.height(); ++v)
        for (int u = 0; u < seen.width(); ++u)
            REQUIRE(std::abs(seen(u, v) - 150) <= 2);
}

TEST_CASE("pixels that the camera does not see are black") {
    LumaResampler resampler(fisheye, {100, 100, 319.5, 239.5, 640, 480});
    const LumaView seen = resampler.run(Luma(640, 360, 255));
    CHECK(seen(0, 0) == 0);
    CHECK(seen(320, 240) == 255);
}

TEST_CASE("depth of a plane is the same plane through another lens and at another size") {
    WorkerPool pool(2);
    for (const double scale : {0.5, 1.0, 2.5}) {
        const Intrinsics to{186 * scale,
                            186 * scale,
                            100 * scale,
                            80 * scale,
                            static_cast<int>(200 * scale),
                            static_cast<int>(160 * scale)};
        const DepthMap map = seen_by<std::uint16_t>(barrel, plane_mm);
        const DepthResampler resampler(barrel, pinhole(to));
        DepthMap shown(to.width, to.height);
        const int covered = resampler.run(map, {}, shown, {}, pool);
        CHECK(covered > 0.95 * to.width * to.height);
        CHECK(covered ==
              to.width * to.height - std::ranges::count(shown.pixels(), std::uint16_t{0}));
        double worst = 0;
        for (int v = 0; v < to.height; ++v)
            for (int u = 0; u < to.width; ++u)
                if (shown(u, v) != 0)
                    worst = std::max(worst, std::abs(shown(u, v) - plane_mm(ray_of(to, u, v))));
        INFO("scale " << scale);
        CHECK(worst < 2);
    }
}

TEST_CASE("nothing is put between two surfaces, and holes stay") {
    WorkerPool pool(1);
    const Intrinsics from{100, 100, 31.5, 23.5, 64, 48}, to{310, 310, 98, 73, 198, 148};
    DepthMap map(64, 48);
    for (int v = 0; v < 48; ++v)
        for (int u = 0; u < 64; ++u)
            map(u, v) = u < 20 ? 1000 : (u < 40 ? 3000 : (u < 44 ? 0 : 2000));
    const DepthResampler resampler(pinhole(from), pinhole(to));
    DepthMap shown(to.width, to.height);
    Image<std::uint8_t> confidence(to.width, to.height), given(64, 48, 200);
    for (int v = 0; v < 48; ++v)
        given(10, v) = 7;
    resampler.run(map, given, shown, confidence, pool);
    for (int v = 0; v < to.height; ++v)
        for (int u = 0; u < to.width; ++u) {
            const double at = (u - to.cx) / to.fx * from.fx + from.cx;
            const int nearest = static_cast<int>(std::lround(at));
            REQUIRE(shown(u, v) == map(std::clamp(nearest, 0, 63), 10));
            REQUIRE(confidence(u, v) == (shown(u, v) == 0 ? 0 : nearest == 10 ? 7 : 200));
        }
}

TEST_CASE("a range along the ray becomes a depth along the axis") {
    TofReadings readings(barrel, true);
    const DepthMap ranges = seen_by<std::uint16_t>(barrel, [](const Eigen::Vector2d &ray) {
        return plane_mm(ray) * ray.homogeneous().norm();
    });
    const DepthView z = readings.run(ranges);
    for (int v = 0; v < z.height(); ++v)
        for (int u = 0; u < z.width(); ++u)
            REQUIRE(std::abs(z(u, v) - plane_mm(*barrel.ray(u, v))) <= 1);
}

TEST_CASE("cameras whose views have nothing in common are recognised") {
    RigCalibration rig{.color = fisheye, .tof = barrel};
    const Intrinsics narrow{4000, 4000, 319.5, 239.5, 640, 480};
    const auto meets = [&](const CameraModel &published) {
        return views_meet(RigGeometry(rig, published, {}));
    };
    CHECK(meets(rig.color));
    CHECK(meets(pinhole(narrow)));
    rig.tof_from_color.R = rotation({0, 0.8, 0});
    CHECK(meets(rig.color));
    CHECK_FALSE(meets(pinhole(narrow)));
    rig.tof_from_color.R = rotation({0, 3, 0});
    CHECK_FALSE(meets(rig.color));
}

TEST_CASE("the working views see what the TOF camera sees, and are no finer than it makes sense") {
    RigCalibration rig{.color = fisheye, .tof = barrel};
    rig.tof_from_color = {rotation({0.01, -0.02, 0.015}), {-0.05, 0.002, 0.001}};
    const Intrinsics own{400, 400, 319.5, 239.5, 640, 480};
    for (const RigGeometry &geometry :
         {RigGeometry(rig, rig.color, {}), RigGeometry(rig, rig.tof, rig.tof_from_color),
          RigGeometry(rig, pinhole(own), {})}) {
        const Views views = working_views(geometry);
        CHECK(views.tracking.width <= 640 + 16);
        CHECK(views.tracking.fx <= fisheye.pinhole.fx);
        CHECK(views.published.fx <=
              std::max(geometry.published.pinhole.fx, geometry.published.pinhole.fy));
        for (const Intrinsics &camera : {views.tracking, views.published, views.surface}) {
            CHECK(camera.width % 16 == 0);
            CHECK(camera.height % 16 == 0);
        }
        CHECK(views.publishes_surface() == (geometry.published == rig.tof));
        CHECK(views.publishes_tracking() == (geometry.published == rig.color));
        // All that the TOF camera reads has a place in the surface's view.
        for (const double u : {0.0, 223.0})
            for (const double v : {0.0, 171.0}) {
                const auto ray = barrel.ray(u, v);
                REQUIRE(ray);
                const Eigen::Vector2d at = views.surface.project(ray->homogeneous());
                CHECK(at.x() > -1);
                CHECK(at.y() > -1);
                CHECK(at.x() < views.surface.width);
                CHECK(at.y() < views.surface.height);
            }
    }
}
