// SPDX-License-Identifier: Apache-2.0
// Points compared with a map in vectors, against the formulas one by one.
#include "core/calibration/depth_comparison.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

using namespace afterglow;

namespace {

const Intrinsics camera{100, 105, 49.5, 34.5, 100, 70};

/// A slope with a step in it and some holes, `bend` times as far as it is.
DepthSurface slope(float bend) {
    DepthMap map(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            map(u, v) = static_cast<std::uint16_t>(1500 + 4 * u + 3 * v + (u > 60 ? 700 : 0));
    for (int k = 20; k < 26; ++k)
        map(k, 40) = 0;
    DepthCorrection correction;
    correction.shape = {bend, -bend, 0.5f * bend};
    WorkerPool pool(1);
    DepthSurface surface(camera, {});
    surface.build(map, pool, correction);
    return surface;
}

ComparedPoints scattered(int count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> ray(-0.6f, 0.6f), depth(1.4f, 2.4f);
    ComparedPoints points;
    points.count = count;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        points.x[i] = ray(random);
        points.y[i] = ray(random) * 0.7f;
        points.z[i] = i % 9 == 8 ? -1.0f : depth(random); // some are behind the camera
    }
    return points;
}

const Pose moved{Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, 1).normalized()).toRotationMatrix(),
                 {0.05, -0.02, 0.03}};

} // namespace

TEST_CASE("points are compared with a map in vectors as one by one", "[core][refinement]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const DepthSurface to = slope(0.02f);
    for (const int count : {1, 5, 64}) {
        const ComparedPoints points = scattered(count);
        const ComparisonOptions options{
            .robust_width2 = 4, .with_shape = true, .from_shape = {0.01f, 0.02f, -0.01f}};
        DepthComparisons out;
        compare_points(points, to, camera, moved, options, out);
        int shown = 0;
        for (std::size_t i = 0; i < ComparedPoints::block; ++i) {
            CAPTURE(count, i);
            if (static_cast<int>(i) >= count) {
                CHECK(out.weight[i] == 0.0f);
                CHECK(out.bin[i] == DepthComparisons::bins);
                continue;
            }
            const double z = points.z[i];
            const Eigen::Vector3d RX = moved.R * (z * Eigen::Vector3d(points.x[i], points.y[i], 1));
            const Eigen::Vector3d Y = RX + moved.T;
            const Eigen::Vector2d p = camera.project(Y);
            const int u = static_cast<int>(std::floor(p.x() + 0.5));
            const int v = static_cast<int>(std::floor(p.y() + 0.5));
            const auto close = [](double x) { return std::abs(x - std::floor(x) - 0.5) < 1e-3; };
            if (close(p.x()) || close(p.y()))
                continue; // either pixel is the nearest
            const bool inside = Y.z() > 0.1 && p.x() >= 3 && p.y() >= 3 && p.x() < 96 && p.y() < 66;
            const auto depth = [&](int du, int dv) { return double(to.z()(u + du, v + dv)); };
            const bool seen = inside && to.edge_distance()(u, v) >= 4 && depth(0, 0) > 0 &&
                              depth(-3, 0) > 0 && depth(3, 0) > 0 && depth(0, -3) > 0 &&
                              depth(0, 3) > 0;
            REQUIRE((out.weight[i] > 0) == seen);
            if (!seen)
                continue;
            ++shown;
            const double du = (depth(3, 0) - depth(-3, 0)) / 6,
                         dv = (depth(0, 3) - depth(0, -3)) / 6;
            const double e = depth(0, 0) + du * (p.x() - u) + dv * (p.y() - v) - Y.z();
            const double sigma = to.noise().sigma(static_cast<float>(depth(0, 0)));
            const double robust = 4 / (e * e / (sigma * sigma) + 4);
            CHECK(out.weight[i] ==
                  Approx(robust * robust / (sigma * sigma)).epsilon(1e-2).margin(1e-3));
            CHECK(std::abs(out.bin[i] - std::min(63.0, std::abs(e) / sigma * 4)) < 1.1);
            const double a = du * camera.fx / Y.z(), b = dv * camera.fy / Y.z();
            const Eigen::Vector3d by_Y{a, b, -(a * Y.x() + b * Y.y()) / Y.z() - 1};
            const Eigen::Vector3d turn = Y.cross(by_Y);
            const auto basis = [](double x, double y) {
                return Eigen::Vector3d(x, y, x * x + y * y);
            };
            const Eigen::Vector3d from = by_Y.dot(RX) * basis(points.x[i], points.y[i]);
            const Eigen::Vector3d here = depth(0, 0) * basis(Y.x() / Y.z(), Y.y() / Y.z());
            for (int k = 0; k < 3; ++k) {
                const auto row = static_cast<std::size_t>(k);
                CHECK(out.J[row][i] == Approx(by_Y[k]).margin(1e-4));
                CHECK(out.J[3 + row][i] == Approx(turn[k]).margin(2e-4));
                CHECK(out.J[6 + row][i] == Approx(from[k] + here[k]).margin(1e-3));
            }
            const double unbent = e - from.dot(options.from_shape.cast<double>()) -
                                  here.dot(to.correction().shape.cast<double>());
            CHECK(out.error[i] == Approx(unbent).margin(1e-4));
        }
        if (count == 64)
            CHECK(shown > 15);
    }
}

TEST_CASE("the error of compared points follows their derivatives in weighted products",
          "[core][refinement]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    DepthComparisons block;
    for (std::size_t i = 0; i < block.J.size(); ++i)
        block.J[i].fill(static_cast<float>(i + 1));
    block.error.fill(100);
    block.weight.fill(0.5f);
    for (const int columns : {6, 9}) {
        WeightedProducts products;
        add_products(block, columns, products);
        add_products(block, columns, products);
        const double sum_of_weights = 2 * 0.5 * ComparedPoints::block;
        for (int i = 0; i < columns; ++i) {
            for (int j = i; j < columns; ++j)
                CHECK(products(i, j) == sum_of_weights * (i + 1) * (j + 1));
            CHECK(products(i, columns) == sum_of_weights * (i + 1) * 100);
        }
    }
}
