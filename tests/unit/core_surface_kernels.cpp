// SPDX-License-Identifier: Apache-2.0
// Kernels against the scalar code that they stand for, bit for bit, on numbers as they come and on
// those that kernels get wrong.
#include "core/keyframe/self_calibration.hpp"
#include "core/keyframe/surface_kernels.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace afterglow;

namespace {

constexpr SensorNoise sensor{
    .floor_m = 0.001f, .linear = 0.0005f, .quadratic_per_m = 0.002f, .least_relative = 0.0015f};

/// Depths of a slope with noise, steps and holes, metres.
std::vector<float> depths(std::mt19937 &random, std::size_t count) {
    std::normal_distribution<float> noise(0.0f, 0.004f);
    std::uniform_int_distribution<int> kind(0, 19);
    std::vector<float> z;
    float surface = 1.5f;
    for (std::size_t i = 0; i < count; ++i) {
        const int is = kind(random);
        if (is == 0)
            surface = 0.5f + 0.2f * static_cast<float>(kind(random));
        z.push_back(is < 3 ? 0.0f : surface + noise(random));
    }
    return z;
}

} // namespace

TEST_CASE("smoothing in vectors is smoothing one by one") {
    std::mt19937 random(1);
    for (const int radius : {1, 2, 3})
        for (const int count : {1, 3, 4, 7, 16, 61}) {
            const int stride = count + 2 * radius, rows = 2 * radius + 1;
            const std::vector<float> map =
                depths(random, static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows));
            const float *row = map.data() + radius * stride + radius;
            std::vector<float> out(static_cast<std::size_t>(count), -1.0f);
            smooth_row({row, stride, radius, count}, sensor, out.data());
            for (int u = 0; u < count; ++u) {
                const float z = row[u], limit = 3.0f * sensor.sigma(z);
                float sum = 0, total = 0.5f;
                for (int dv = 0; dv <= radius; ++dv)
                    for (int du = dv == 0 ? 1 : -radius; du <= radius; ++du) {
                        const float a = row[u - dv * stride - du], b = row[u + dv * stride + du];
                        const float mean = 0.5f * (a + b);
                        if (a == 0.0f || b == 0.0f || !(std::abs(mean - z) < limit) ||
                            !(std::abs(a - b) < 2.0f * limit + 0.1f * z))
                            continue;
                        sum += mean;
                        total += 1.0f;
                    }
                CAPTURE(radius, count, u, z);
                REQUIRE(out[static_cast<std::size_t>(u)] ==
                        (z == 0.0f ? 0.0f : (0.5f * z + sum) / total));
            }
        }
}

TEST_CASE("readings become depths in vectors as one by one") {
    std::mt19937 random(2);
    std::uniform_int_distribution<int> any(0, 65535);
    const DepthCorrection correction{.shape = {0.01f, -0.02f, 0.015f}};
    for (const int count : {1, 5, 16, 33}) {
        std::vector<std::uint16_t> millimetres{0, 100, 99, 12000, 65535, 1};
        while (millimetres.size() < static_cast<std::size_t>(count))
            millimetres.push_back(static_cast<std::uint16_t>(any(random)));
        const ReadingRow row = {millimetres.data(), count, -0.6f, 0.002f, 0.35f,
                                correction.shape,   0.1f,  12.0f};
        std::vector<float> z(millimetres.size(), -1.0f);
        int valid = 0;
        const int found = load_row(row, z.data());
        for (int u = 0; u < count; ++u) {
            const auto i = static_cast<std::size_t>(u);
            const float depth = 0.001f * static_cast<float>(millimetres[i]) *
                                correction.scale(row.x0 + row.dx * static_cast<float>(u), row.y);
            const bool ok = depth >= row.nearest_m && depth <= row.farthest_m;
            CAPTURE(count, u, depth);
            REQUIRE(z[i] == (ok ? Approx(depth).epsilon(1e-6) : Approx(0.0)));
            valid += ok;
        }
        REQUIRE(found == valid);
    }
}

TEST_CASE("neighbours are compared in vectors as one by one") {
    std::mt19937 random(3);
    const EdgeRule rule = {0.02f, sensor};
    for (const int count : {1, 2, 15, 16, 640}) {
        const auto a = depths(random, static_cast<std::size_t>(count));
        auto b = depths(random, static_cast<std::size_t>(count));
        for (std::size_t i = 0; i < b.size(); i += 2)
            b[i] = a[i] * 1.003f; // some are of one surface
        std::vector<Neighbours> found(a.size());
        const Slopes slopes = compare_neighbours(a.data(), b.data(), count, rule, found.data());
        int pairs = 0;
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const float near = std::min(a[i], b[i]), difference = std::abs(a[i] - b[i]);
            const bool parted = difference > rule.edge_relative * near + 3.0f * sensor.sigma(near);
            const Neighbours expected = a[i] == 0.0f   ? Neighbours::alike
                                        : b[i] == 0.0f ? Neighbours::hole
                                        : parted       ? Neighbours::parted
                                                       : Neighbours::alike;
            CAPTURE(count, i, a[i], b[i]);
            REQUIRE(found[i] == expected);
            if (a[i] != 0.0f && b[i] != 0.0f && !parted) {
                ++pairs;
                sum += std::max(0.0f, difference - sensor.sigma(near)) / near;
            }
        }
        CHECK(slopes.pairs == pairs);
        CHECK(std::ldexp(static_cast<double>(slopes.sum), -20) == Approx(sum).margin(1e-6 * count));
    }
}

TEST_CASE("a distance is at most one more than the next row's") {
    const std::vector<std::uint8_t> next{0, 1, 7, 7, 254, 3, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 6};
    std::vector<std::uint8_t> values(next.size(), std::uint8_t{7});
    grow_from_row(next.data(), static_cast<int>(next.size()), values.data());
    CHECK(values == std::vector<std::uint8_t>{1, 2, 7, 7, 7, 4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 7});
}
