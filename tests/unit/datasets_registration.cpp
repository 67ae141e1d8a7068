// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/lens.hpp"
#include "eval/datasets/registration.hpp"
#include "eval/datasets/scale.hpp"
#include "tests/catch.hpp"

#include <cmath>
#include <cstdlib>
#include <optional>

using namespace afterglow;

namespace {

/// A point of the scene, and on what.
struct Hit {
    Eigen::Vector3d X;
    bool on_box;
};

/// A slanted wall about 2 m away and, before it, the front of a box at 1 m; in the depth camera's
/// frame.
Hit trace(const Eigen::Vector3d &origin, const Eigen::Vector3d &ray) {
    const Eigen::Vector3d at_box = origin + (1.0 - origin.z()) / ray.z() * ray;
    if (std::abs(at_box.x()) < 0.25 && std::abs(at_box.y()) < 0.15)
        return {at_box, true};
    const Eigen::Vector3d normal(0.3, -0.2, 1);
    return {origin + (2.0 - normal.dot(origin)) / normal.dot(ray) * ray, false};
}

struct Cameras {
    Intrinsics depth = {240, 242, 161, 118, 320, 240};
    LensDistortion lens = {-0.1, 0.2, 0.002, -0.001, -0.05};
    Pose depth_to_color = {rotation({0.01, -0.02, 0.008}), {-0.052, 0.003, 0.004}};
    Intrinsics color = {310, 308, 158, 122, 320, 240};

    Eigen::Vector3d depth_ray(int u, int v) const {
        const Eigen::Vector2d x =
            lens.undistort({(u - depth.cx) / depth.fx, (v - depth.cy) / depth.fy});
        return {x.x(), x.y(), 1};
    }
    /// What the colour camera sees at a pixel.
    Hit color_hit(double u, double v) const {
        const Pose back = depth_to_color.inverse();
        return trace(back.T, back.R * color.back_project(u, v, 1));
    }
    Image<float> measured() const {
        Image<float> metres(depth.width, depth.height);
        for (int v = 0; v < depth.height; ++v)
            for (int u = 0; u < depth.width; ++u)
                metres(u, v) =
                    static_cast<float>(trace(Eigen::Vector3d::Zero(), depth_ray(u, v)).X.z());
        return metres;
    }
    DepthMap registered(const Image<float> &metres) const {
        return DepthRegistration(depth, lens, depth_to_color, color).registered(metres.view());
    }
    /// What lies under a colour pixel and all around it within `radius` pixels, if it is one thing.
    std::optional<bool> on_box_around(int u, int v, double radius) const {
        const bool here = color_hit(u, v).on_box;
        for (const double du : {-radius, 0.0, radius})
            for (const double dv : {-radius, 0.0, radius})
                if (color_hit(u + du, v + dv).on_box != here)
                    return std::nullopt;
        return here;
    }
    /// Whether the depth camera saw the scene's point, well within its image and off silhouettes.
    bool was_measured(const Hit &hit) const {
        const Eigen::Vector2d x = lens.distort({hit.X.x() / hit.X.z(), hit.X.y() / hit.X.z()});
        const double u = depth.fx * x.x() + depth.cx, v = depth.fy * x.y() + depth.cy;
        if (u < 2 || v < 2 || u > depth.width - 3 || v > depth.height - 3)
            return false;
        for (const int du : {-2, 0, 2})
            for (const int dv : {-2, 0, 2}) {
                const Eigen::Vector3d ray =
                    depth_ray(static_cast<int>(u) + du, static_cast<int>(v) + dv);
                if (trace(Eigen::Vector3d::Zero(), ray).on_box != hit.on_box)
                    return false;
            }
        return true;
    }
};

} // namespace

TEST_CASE("registered depth is what the colour camera would have measured, to the millimetre") {
    const Cameras cameras;
    const DepthMap depth = cameras.registered(cameras.measured());
    int wrong = 0, holes = 0, compared = 0, box = 0;
    for (int v = 0; v < depth.height(); ++v) {
        for (int u = 0; u < depth.width(); ++u) {
            if (!cameras.on_box_around(u, v, 1.5))
                continue;
            const Hit hit = cameras.color_hit(u, v);
            const double mm = 1000 * (cameras.depth_to_color * hit.X).z();
            if (depth(u, v) == 0) {
                holes += cameras.was_measured(hit);
                continue;
            }
            ++compared;
            box += hit.on_box;
            // The outermost points are drawn at the nearest pixel.
            wrong += std::abs(depth(u, v) - mm) > (cameras.was_measured(hit) ? 1.0 : 3.0);
        }
    }
    CHECK(compared > 60000);
    CHECK(box > 10000);
    CHECK(wrong == 0);
    CHECK(holes == 0);
}

TEST_CASE("depth registration widens silhouettes by at most one pixel") {
    const Cameras cameras;
    const DepthMap depth = cameras.registered(cameras.measured());
    int fat = 0;
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u)
            if (depth(u, v) != 0 && depth(u, v) < 1200 && cameras.on_box_around(u, v, 1) == false)
                ++fat;
    CHECK(fat == 0);
}

TEST_CASE("depth registration does not draw hidden background over the foreground") {
    Cameras cameras;
    cameras.depth_to_color.T.x() = -0.2;
    const DepthMap depth = cameras.registered(cameras.measured());
    int through = 0, inside = 0;
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u)
            if (cameras.on_box_around(u, v, 1.5) == true) {
                ++inside;
                through += depth(u, v) > 1100;
            }
    CHECK(inside > 10000);
    CHECK(through == 0);
}

TEST_CASE("depth registration keeps an object one pixel wide") {
    Cameras cameras;
    cameras.lens = {};
    cameras.depth_to_color = {};
    cameras.color = cameras.depth;
    Image<float> metres(320, 240, 2.0f);
    for (int v = 0; v < 240; ++v)
        metres(100, v) = 1.0f;
    const DepthMap depth = cameras.registered(metres);
    CHECK(depth(100, 120) == 1000);
    CHECK(depth(99, 120) == 2000);
    CHECK(depth(101, 120) == 2000);
}

TEST_CASE("depth registration of a camera to itself changes nothing") {
    Cameras cameras;
    cameras.lens = {};
    cameras.depth_to_color = {};
    cameras.color = cameras.depth;
    Image<float> metres = cameras.measured();
    metres(5, 5) = 0;
    metres(6, 6) = std::nanf("");
    metres(7, 7) = -1;
    const DepthMap depth = cameras.registered(metres);
    int different = 0;
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            if (metres(u, v) > 0)
                different += std::abs(depth(u, v) - 1000.0 * double(metres(u, v))) > 0.51;
    CHECK(different == 0);
    CHECK(depth(5, 5) == 0);
    CHECK(depth(6, 6) == 0);
    CHECK(depth(7, 7) == 0);
}

TEST_CASE("depth registration handles empty, zero-distance and far depth maps") {
    const Cameras cameras;
    for (const float metres : {0.0f, 0.0001f, 100.0f}) {
        const DepthMap depth = cameras.registered(Image<float>(320, 240, metres));
        for (const std::uint16_t mm : depth.pixels())
            REQUIRE(mm < 200);
    }
}

TEST_CASE("undistorting a point inverts the lens distortion") {
    const LensDistortion lens = {0.208, -0.586, 0.0007, 0.001, 0.4986};
    for (const double x : {-0.6, -0.1, 0.0, 0.3, 0.6})
        for (const double y : {-0.45, 0.0, 0.2, 0.45})
            CHECK((lens.distort(lens.undistort({x, y})) - Eigen::Vector2d(x, y)).norm() < 1e-9);
}

TEST_CASE("an undistorted image equals the pinhole camera's") {
    const Intrinsics camera = {200, 205, 101, 73, 200, 150};
    const LensDistortion lens = {0.2, -0.3, 0.001, -0.002, 0};
    // A ramp over the scene, linear in what a pinhole sees, taken through the lens.
    const auto brightness = [](const Eigen::Vector2d &x) { return 128 + 150 * x.x() + 80 * x.y(); };
    Luma taken(200, 150);
    for (int v = 0; v < 150; ++v)
        for (int u = 0; u < 200; ++u)
            taken(u, v) = static_cast<std::uint8_t>(std::lround(brightness(
                lens.undistort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy}))));
    const Luma straight = undistorted(taken.view(), camera, lens);
    for (int v = 10; v < 140; ++v)
        for (int u = 10; u < 190; ++u)
            REQUIRE(std::abs(straight(u, v) - brightness({(u - camera.cx) / camera.fx,
                                                          (v - camera.cy) / camera.fy})) < 1.1);
}

TEST_CASE("a large dataset image is cropped to the centre and averaged") {
    Luma large(1920, 1080, 10);
    for (int v = 0; v < 1080; ++v)
        for (int u = 240; u < 1680; ++u)
            large(u, v) = static_cast<std::uint8_t>(u % 2 == 0 ? 100 : 200);
    const Luma small = cropped_and_shrunk(large.view(), 640, 480);
    CHECK(small.width() == 640);
    CHECK(small.height() == 480);
    for (const std::uint8_t pixel : small.pixels()) // 2.25 columns: at most 1.25 of one kind
        REQUIRE((pixel >= 144 && pixel <= 156));
    CHECK(cropped_and_shrunk(small.view(), 640, 480) == small);
}
