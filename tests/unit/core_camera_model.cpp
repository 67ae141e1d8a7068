// SPDX-License-Identifier: Apache-2.0
#include "core/base/camera_model.hpp"
#include "tests/catch.hpp"

#include <cmath>
#include <numbers>
#include <random>

using namespace afterglow;

namespace {

struct Named {
    const char *name;
    CameraModel camera;
};

// Sizes, focal lengths and coefficients as calibrations of such cameras give them.
const Named typical[] = {
    {"webcam, 5 coefficients",
     {{910.5, 911.25, 641.25, 358.5, 1280, 720},
      Lens::brown_conrady,
      {0.12, -0.25, 0.0011, -0.0007, 0.09}}},
    {"barrel, 4 coefficients",
     {{430, 428, 318.5, 241, 640, 480}, Lens::brown_conrady, {-0.32, 0.11, 0.0004, 0.0009}}},
    {"rational, 8 coefficients",
     {{611.3, 611.1, 637.5, 367.2, 1280, 720},
      Lens::brown_conrady,
      {0.472, -2.61, 0.00052, -0.00031, 1.51, 0.351, -2.43, 1.437}}},
    {"pincushion", {{190, 190, 112, 86, 224, 172}, Lens::brown_conrady, {0.5, 0.3}}},
    {"fisheye",
     {{425.7, 426.1, 420.3, 398.9, 848, 800},
      Lens::kannala_brandt,
      {-0.0082, 0.0451, -0.0423, 0.0081}}},
    {"wide fisheye",
     {{260, 261, 319, 243, 640, 480}, Lens::kannala_brandt, {0.05, 0.02, -0.004, 0.0006}}},
    {"equidistant", {{270, 270, 320, 240, 640, 480}, Lens::kannala_brandt, {}}},
    {"no lens", {{525, 525, 319.5, 239.5, 640, 480}, Lens::pinhole, {}}},
};

Eigen::Vector2d project(const CameraModel &camera, const Eigen::Vector2d &ray) {
    return camera.project({ray.x(), ray.y(), 1});
}

/// How far from the axis a lens without tangential part keeps the order of radii, found by small
/// steps; at most `farthest`.
double fold(const CameraModel &camera, double farthest) {
    constexpr double step = 1e-4;
    for (double r = step; r < farthest; r += step)
        if (!(project(camera, {r, 0}).x() > project(camera, {r - step, 0}).x()))
            return r - step;
    return farthest;
}

} // namespace

TEST_CASE("every pixel's ray is seen at this pixel") {
    for (const auto &[name, camera] : typical) {
        INFO(name);
        double worst = 0;
        for (int v = 0; v < camera.pinhole.height; v += 3)
            for (int u = 0; u < camera.pinhole.width; u += 3) {
                const auto ray = camera.ray(u, v);
                REQUIRE(ray);
                worst = std::max(worst, (project(camera, *ray) - Eigen::Vector2d(u, v)).norm());
            }
        CHECK(worst < 1e-6);
    }
}

TEST_CASE("cameras see points where OpenCV's functions see them") {
    // Of the first two: cv::projectPoints and cv::fisheye::projectPoints of OpenCV 4.6.0, without
    // rotation and translation.
    const Eigen::Vector3d points[] = {{0.1, -0.05, 1},   {-0.4, 0.25, 0.9}, {0.6, 0.4, 1.1},
                                      {-1.2, -0.7, 1.5}, {0.02, 0.9, 2},    {3, -2, 1.5}};
    struct Seen {
        const Named &named;
        std::vector<Eigen::Vector2d> at;
    };
    const Seen seen[] = {
        {typical[0],
         {{732.4023049893, 312.8948483386},
          {229.4488482060, 616.2535582615},
          {1143.8592335554, 694.4623544308},
          {-70.1301829387, -55.6346065200},
          {650.3695020490, 775.2342173122}}},
        {typical[1],
         {{361.3395965625, 219.6843761875},
          {142.8182778328, 350.4035327787},
          {526.0203554402, 378.6666428796},
          {42.0379064691, 80.4346452807},
          {322.6206691175, 422.0904613774}}},
        {typical[2],
         {{698.7110484480, 336.6072771781},
          {359.5057418803, 540.9443320269},
          {980.8987702094, 596.2484515369},
          {128.0084171763, 70.4611816295},
          {643.6876720065, 647.3456551214}}},
        {typical[4],
         {{462.6899244628, 377.6851223707},
          {246.0263195922, 507.9233956157},
          {626.0068946568, 536.1667885260},
          {144.7917726753, 238.0358566985},
          {424.2990544746, 579.0265445680},
          {833.9590154343, 122.8681990814}}},
    };
    for (const auto &[named, at] : seen)
        for (std::size_t i = 0; i < at.size(); ++i) {
            INFO(named.name << ", point " << i);
            CHECK((named.camera.project(points[i]) - at[i]).norm() < 1e-8);
            // What cv::undistortPoints and cv::fisheye::undistortPoints give for these pixels.
            const auto ray = named.camera.ray(at[i].x(), at[i].y());
            REQUIRE(ray);
            CHECK((*ray - points[i].head<2>() / points[i].z()).norm() < 1e-9);
        }
}

TEST_CASE("a pixel beyond what the lens shows has no ray") {
    // x (1 - 0.3 x^2) is highest at x^2 = 1 / 0.9, where it is 2 / 3 x.
    const CameraModel barrel{{500, 500, 320, 240, 640, 480}, Lens::brown_conrady, {-0.3}};
    const double highest = 320 + 500 * std::sqrt(1 / 0.9) * 2 / 3;
    CHECK(barrel.ray(highest - 0.01, 240));
    CHECK_FALSE(barrel.ray(highest + 0.01, 240));
    CHECK_FALSE(barrel.ray(1e6, 240));
    // At right angles to the axis and behind.
    const CameraModel equidistant{{250, 250, 320, 240, 640, 480}, Lens::kannala_brandt, {}};
    const double right_angle = 250 * std::numbers::pi / 2;
    CHECK(equidistant.ray(320 + right_angle * 0.98, 240));
    CHECK_FALSE(equidistant.ray(320 + right_angle, 240));
    CHECK_FALSE(equidistant.ray(320, 240 - 1.5 * right_angle));
    CHECK_FALSE(equidistant.ray(320 + 3 * right_angle, 240));
}

TEST_CASE("a lens that rises again after it has turned back shows nothing there") {
    // 1 - 1.2 q + 0.4 q^2: the radius turns back at 0.59, and rises again from 1.08 on.
    const CameraModel camera{{500, 500, 0, 0, 640, 480}, Lens::brown_conrady, {-1.2, 0.4}};
    const double turns = fold(camera, 3);
    CHECK(turns == Approx(0.59).margin(0.1));
    const double highest = project(camera, {turns, 0}).x();
    const Eigen::Vector2d again = project(camera, {2.5, 0});
    REQUIRE(again.x() > highest);
    CHECK_FALSE(camera.ray(again.x(), 0));
    const auto ray = camera.ray(highest * 0.9, 0);
    REQUIRE(ray);
    CHECK(ray->x() < turns);
}

TEST_CASE("whatever the coefficients, rays are found up to where the lens turns back") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    int folded = 0;
    for (int i = 0; i < 300; ++i) {
        CameraModel camera{{500, 500, 320, 240, 640, 480}, Lens::brown_conrady, {}};
        auto &k = camera.distortion;
        if (i % 3 == 0) {
            camera.lens = Lens::kannala_brandt;
            k = {0.3 * any(random), 0.3 * any(random), 0.1 * any(random), 0.05 * any(random)};
        } else if (i % 3 == 1) {
            k = {any(random), any(random), 0, 0, any(random)};
        } else {
            k = {any(random), 3 * any(random), 0,          0, any(random),
                 any(random), 3 * any(random), any(random)};
        }
        INFO(i << ": " << k[0] << " " << k[1] << " " << k[4] << " " << k[5] << " " << k[6] << " "
               << k[7] << " " << k[2] << " " << k[3]);
        constexpr double farthest = 4;
        const double turns = fold(camera, farthest);
        folded += turns < farthest;
        for (const double share : {0.01, 0.3, 0.6, 0.9, 0.98}) {
            const Eigen::Vector2d wanted = turns * share * Eigen::Vector2d(0.6, -0.8);
            const Eigen::Vector2d pixel = project(camera, wanted);
            const auto ray = camera.ray(pixel.x(), pixel.y());
            REQUIRE(ray);
            CHECK((*ray - wanted).norm() < 1e-5 * (1 + wanted.norm()));
        }
        // What is given elsewhere is seen there, and no farther off than the lens turns back.
        for (int pixel = 0; pixel < 640; pixel += 16)
            if (const auto ray = camera.ray(pixel, 2.0 * pixel); ray && turns < farthest) {
                CHECK(ray->norm() < turns + 1e-3);
                CHECK((project(camera, *ray) - Eigen::Vector2d(pixel, 2.0 * pixel)).norm() < 1e-3);
            }
    }
    CHECK(folded > 30);
    CHECK(folded < 270);
}

TEST_CASE("numbers that are none give no ray") {
    for (const auto &[name, camera] : typical) {
        if (camera.lens == Lens::pinhole)
            continue;
        INFO(name);
        CameraModel broken = camera;
        broken.distortion[1] = NAN;
        CHECK_FALSE(broken.ray(3, 5));
        CHECK_FALSE(camera.ray(NAN, 5));
        CHECK_FALSE(camera.ray(INFINITY, 5));
    }
}
