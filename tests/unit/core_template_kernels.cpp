// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/template_kernels.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

using namespace afterglow;

TEST_CASE("the steepest gradient of each image column is found as pixel by pixel", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(9);
    const int width = GENERATE(3, 4, 7, 10, 17, 40, 67);
    const int height = GENERATE(3, 9, 12);
    CAPTURE(width, height);
    // Few grey values: gradients are often equal, and often zero.
    std::uniform_int_distribution<int> grey(0, 3);
    GreyImage image(width, height);
    for (Grey &pixel : image.pixels())
        pixel = static_cast<Grey>(85 * grey_steps * grey(random));
    const auto half_difference = [](Grey a, Grey b) {
        return 0.5f * grey_step * static_cast<float>(a - b);
    };
    for (int first = 1; first < height - 1; ++first)
        for (int end = first + 1; end < height; ++end) {
            std::vector<float> steepness(static_cast<std::size_t>(width), -1.0f);
            std::vector<int> rows(static_cast<std::size_t>(width), -1);
            find_steepest(image, first, end, steepness, rows);
            CHECK(steepness.front() == -1);
            CHECK(steepness.back() == -1);
            for (int u = 1; u < width - 1; ++u) {
                float most = -1;
                int at = -1;
                for (int v = first; v < end; ++v) {
                    const float gx = half_difference(image(u + 1, v), image(u - 1, v));
                    const float gy = half_difference(image(u, v + 1), image(u, v - 1));
                    if (gx * gx + gy * gy > most) {
                        most = gx * gx + gy * gy;
                        at = v;
                    }
                }
                CAPTURE(first, end, u);
                REQUIRE(steepness[static_cast<std::size_t>(u)] == most);
                REQUIRE(rows[static_cast<std::size_t>(u)] == at);
            }
        }
}

TEST_CASE("the pixels of an image and the columns of a template begin with a cache line",
          "[core]") {
    const auto offset_of = [](const void *memory) {
        return reinterpret_cast<std::uintptr_t>(memory) % cache_line;
    };
    // Of several at once: one may begin there by chance.
    const std::vector<Image<float>> images(8, Image<float>(641, 3));
    const std::vector<TemplatePoints> templates(8, TemplatePoints(100));
    for (const Image<float> &image : images)
        CHECK(offset_of(image.row(0)) == 0);
    for (const TemplatePoints &points : templates) {
        CHECK(offset_of(points.x.data()) == 0);
        for (int k = 0; k < TemplatePoints::derivatives; ++k)
            CHECK(offset_of(points.J.row(k)) == 0);
    }
}

TEST_CASE("points of a template are completed as one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const Intrinsics camera{130, 140, 79.5, 61, 160, 120};
    const TemplateOptions options{.pixel_noise = 3, .blur_px = 0.2f};
    TemplatePoints points(100);
    points.count = 77;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> some(-1, 1);
    FoundPoints found;
    for (AlignedVector<float> *column : {&found.u, &found.v, &found.gradient_u, &found.gradient_v})
        column->resize(points.x.size());
    for (std::size_t i = 0; i < 77; ++i) {
        found.u[i] = static_cast<float>(random() % 160);
        found.v[i] = static_cast<float>(random() % 120);
        found.gradient_u[i] = 40 * some(random);
        found.gradient_v[i] = 40 * some(random);
        points.z[i] = 2 + some(random);
        points.intensity[i] = static_cast<float>(random() % 256);
    }
    complete_points(found, camera, options, points);
    // Behind the last point, too.
    CHECK(std::ranges::all_of(points.J.pixels(), [](float value) { return std::isfinite(value); }));
    for (std::size_t i = 0; i < 77; ++i) {
        const Eigen::Vector3d X =
            camera.back_project(found.u[i], found.v[i], static_cast<double>(points.z[i]));
        CAPTURE(i);
        REQUIRE(points.x[i] == Approx(X.x()).margin(1e-5));
        REQUIRE(points.y[i] == Approx(X.y()).margin(1e-5));
        REQUIRE(points.row[i] == Approx(found.v[i] / 120 - 0.5).margin(1e-6));
        const double gx = found.gradient_u[i], gy = found.gradient_v[i];
        REQUIRE(points.per_s[i] == Approx(1 / std::sqrt(9 + 0.04 * (gx * gx + gy * gy))));
        const double z = X.z();
        const Eigen::RowVector3d by_place(gx * camera.fx / z, gy * camera.fy / z,
                                          -(gx * camera.fx * X.x() + gy * camera.fy * X.y()) /
                                              (z * z));
        const auto row = static_cast<Eigen::Index>(i);
        for (Eigen::Index k = 0; k < 3; ++k) {
            const double by_turn = by_place.dot(Eigen::Vector3d::Unit(k).cross(X));
            CAPTURE(k);
            REQUIRE(points.J(row, k) == Approx(by_place[k]).margin(1e-2));
            REQUIRE(points.J(row, 3 + k) == Approx(by_turn).margin(1e-2));
            REQUIRE(points.J(row, TemplatePoints::by_skew + k) ==
                    Approx(by_turn * points.row[i]).margin(1e-2));
        }
        REQUIRE(points.J(row, TemplatePoints::by_gain) ==
                Approx(0.01 * (points.intensity[i] - 128)).margin(1e-5));
    }
}
