// SPDX-License-Identifier: Apache-2.0
// Kernels against the scalar code that they stand for, bit for bit, on numbers as they come and on
// those that kernels get wrong.
#include "core/keyframe/self_calibration.hpp"
#include "core/keyframe/surface_kernels.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

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

/// The same in units, with what kernels read past the end.
std::vector<UnitDepth> unit_depths(std::mt19937 &random, std::size_t count,
                                   const DepthUnits &units) {
    std::vector<UnitDepth> z;
    for (const float metres : depths(random, count + row_slack))
        z.push_back(static_cast<UnitDepth>(std::lround(metres * units.per_metre())));
    return z;
}

float sigma_in_units(int z, const DepthUnits &units, float factor) {
    const float per_metre = units.per_metre(), metres = units.metres();
    const auto depth = static_cast<float>(z);
    const float curve = factor * sensor.linear + depth * (factor * sensor.quadratic_per_m * metres);
    return std::max(factor * sensor.floor_m * per_metre + depth * curve,
                    factor * sensor.least_relative * depth);
}

/// What the kernels multiply 16 bits with.
int fixed_point(int a, int b) {
    return (a * b + (1 << 14)) >> 15;
}

} // namespace

TEST_CASE("smoothing in vectors is smoothing one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(1);
    struct Window {
        int radius, step;
    };
    for (const float farthest : {12.0f, 30.0f})
        for (const auto [radius, step] :
             {Window{1, 1}, {2, 1}, {2, 2}, {3, 1}, {3, 2}, {8, 1}, {8, 2}})
            for (const int count : {1, 3, 4, 7, 16, 61}) {
                const DepthUnits units(farthest);
                const int stride = count + 2 * radius, rows = 2 * radius + 1;
                const auto map = unit_depths(
                    random, static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows),
                    units);
                const UnitDepth *row = map.data() + radius * stride + radius;
                std::vector<float> out(static_cast<std::size_t>(count) + 1, -1.0f);
                smooth_row({row, stride, radius, count, step == 2}, sensor, units, out.data());
                const int reach = radius / step * step;
                for (int u = 0; u < count; ++u) {
                    const int z = row[u], tenth = fixed_point(z, 3277);
                    const int limit =
                        std::min({static_cast<int>(sigma_in_units(z, units, 6) + 0.9999f),
                                  z - tenth, 32767 / (radius == 2 ? 12 : 17)});
                    int sum = 0, pairs = 0;
                    for (int dv = 0; dv <= reach; dv += step)
                        for (int du = dv == 0 ? step : -reach; du <= reach; du += step) {
                            const int a = row[u - dv * stride - du], b = row[u + dv * stride + du];
                            if (a == 0 || b == 0 || std::abs(a + b - 2 * z) >= limit ||
                                std::abs(a - b) >= limit + tenth)
                                continue;
                            sum += a + b - 2 * z;
                            ++pairs;
                        }
                    const float mean = static_cast<float>(z) +
                                       static_cast<float>(sum) / static_cast<float>(2 * pairs + 1);
                    CAPTURE(farthest, radius, step, count, u, z, sum, pairs);
                    REQUIRE(out[static_cast<std::size_t>(u)] == mean * units.metres());
                }
                CHECK(out.back() == -1.0f);
            }
}

TEST_CASE("smoothing takes no hole and nothing far away for a neighbour") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    // Sums of the largest depths leave 16 bits.
    const DepthUnits units(15.0f);
    for (const int z : {1, 200, 7000, 16384, 29999, 30000})
        for (const int other : {0, 1, 200, 16384, 30000}) {
            if (std::abs(z - other) < z / 2)
                continue;
            std::vector<UnitDepth> map(5 * 12 + row_slack, static_cast<UnitDepth>(other));
            UnitDepth *row = map.data() + 2 * 12 + 2;
            std::fill(row, row + 8, static_cast<UnitDepth>(0));
            row[3] = static_cast<UnitDepth>(z);
            std::vector<float> out(8);
            // So noisy that a hole would lie within three sigmas.
            smooth_row({row, 12, 2, 8, false}, sensor.times(16), units, out.data());
            CAPTURE(z, other);
            CHECK(out[3] == static_cast<float>(z) * units.metres());
            CHECK(out[4] == 0.0f);
        }
}

TEST_CASE("readings become depths in vectors as one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(2);
    std::uniform_int_distribution<int> any(0, 65535), bend(-3000, 3000);
    for (const float farthest : {12.0f, 30.0f})
        for (const bool bent : {false, true})
            for (const int count : {1, 5, 8, 16, 33}) {
                const DepthUnits units(farthest);
                std::vector<std::uint16_t> millimetres{0, 100, 99, 12000, 65535, 1, 16384, 32768};
                std::vector<std::int16_t> by_column;
                while (millimetres.size() < static_cast<std::size_t>(count))
                    millimetres.push_back(static_cast<std::uint16_t>(any(random) >> 2));
                for (std::size_t i = 0; i < millimetres.size(); ++i)
                    by_column.push_back(static_cast<std::int16_t>(bend(random)));
                const std::int16_t by_row = -200;
                const ReadingRow row = {millimetres.data(),
                                        count,
                                        bent ? by_column.data() : nullptr,
                                        by_row,
                                        static_cast<UnitDepth>(0.1f * units.per_metre()),
                                        static_cast<UnitDepth>(farthest * units.per_metre())};
                std::vector<UnitDepth> z(static_cast<std::size_t>(count) + 1, UnitDepth{-1});
                const int found = load_row(row, units, z.data());
                int valid = 0;
                for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
                    int depth = std::min<int>(millimetres[i], 32767 / units.per_millimetre()) *
                                units.per_millimetre();
                    if (bent)
                        depth = std::min(depth + fixed_point(depth, by_column[i] + by_row), 32767);
                    const bool ok = depth >= row.nearest && depth <= row.farthest;
                    CAPTURE(farthest, bent, count, i, depth);
                    REQUIRE(z[i] == (ok ? depth : 0));
                    valid += ok;
                }
                CHECK(found == valid);
                CHECK(z.back() == -1);
            }
}

TEST_CASE("neighbours are compared in vectors as one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(3);
    const EdgeRule rule = {0.02f, sensor};
    const DepthUnits units(12.0f);
    for (const int count : {1, 2, 8, 15, 16, 640}) {
        const auto size = static_cast<std::size_t>(count);
        const auto a = unit_depths(random, size, units);
        auto b = unit_depths(random, size, units);
        for (std::size_t i = 0; i < size; i += 2)
            b[i] = static_cast<UnitDepth>(a[i] + a[i] / 300); // some are of one surface
        const auto steps_of = [&](const std::vector<UnitDepth> &z) {
            std::vector<std::int16_t> steps(size + row_slack);
            find_steps(z.data(), count, rule, units, steps.data());
            for (std::size_t i = 0; i < size; ++i) {
                const float twice = 2 * rule.edge_relative * static_cast<float>(z[i]) +
                                    sigma_in_units(z[i], units, 6);
                REQUIRE(steps[i] == (z[i] == 0 ? 0 : static_cast<int>(twice)));
            }
            return steps;
        };
        const auto steps = steps_of(a), steps_below = steps_of(b);
        std::vector<std::uint8_t> flags(size + 1, std::uint8_t{9});
        compare_neighbours({a.data(), steps.data()}, {b.data(), steps_below.data()}, count,
                           flags.data());
        for (std::size_t i = 0; i < size; ++i) {
            const auto parted = [&](int other, int step) {
                return a[i] != 0 && 2 * std::abs(a[i] - other) > std::min<int>(steps[i], step);
            };
            // Of the last one and what follows nothing is asked.
            const bool right = parted(a[i + 1], steps[i + 1]) && i + 1 < size;
            CAPTURE(count, i, a[i], a[i + 1], b[i]);
            if (i + 1 < size)
                CHECK(((flags[i] & parted_from_right) != 0) == right);
            CHECK(((flags[i] & parted_from_below) != 0) == parted(b[i], steps_below[i]));
        }
        CHECK(flags.back() == 9);

        const Slopes slopes = find_slopes(a.data(), b.data(), count, rule, units);
        int pairs = 0;
        double sum = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const auto near = static_cast<float>(std::min(a[i], b[i]));
            const auto difference = static_cast<float>(std::abs(a[i] - b[i]));
            const float deviation = sigma_in_units(static_cast<int>(near), units, 1);
            if (near == 0 || difference > rule.edge_relative * near + 3 * deviation)
                continue;
            ++pairs;
            sum += std::min(1.0f, std::max(0.0f, difference - deviation) / near);
        }
        CHECK(slopes.pairs == pairs);
        CHECK(slopes.sum == Approx(sum).epsilon(1e-5).margin(1e-6));
    }
}

TEST_CASE("a distance is at most one more than the next row's") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const std::vector<std::uint8_t> next{0, 1, 7, 7, 254, 3, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 6};
    std::vector<std::uint8_t> values(next.size(), std::uint8_t{7});
    grow_from_row(next.data(), static_cast<int>(next.size()), values.data());
    CHECK(values == std::vector<std::uint8_t>{1, 2, 7, 7, 7, 4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 7});
}

TEST_CASE("cracks are pixels between two that are inside a surface, alike in vectors and singly",
          "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(8);
    for (int round = 0; round < 200; ++round) {
        const int count = 1 + static_cast<int>(random() % 70);
        const unsigned one_in = round % 2 == 0 ? 2 : 6; // is outside
        std::vector<std::vector<std::uint8_t>> rows(5);
        for (auto &row : rows)
            for (int u = 0; u < count + 4; ++u)
                row.push_back(random() % one_in != 0);
        std::vector<std::uint8_t> cracks(static_cast<std::size_t>(count), 9);
        const auto row = [&](std::size_t i) { return rows[i].data() + 2; };
        find_cracks({row(0), row(1), row(2), row(3), row(4)}, count, cracks.data());
        for (int u = 0; u < count; ++u) {
            const auto inside = [&](int du, int dv) {
                return rows[static_cast<std::size_t>(2 + dv)][static_cast<std::size_t>(2 + u + du)];
            };
            bool between = false;
            for (const auto &[du, dv] : {std::pair(1, 0), {0, 1}, {1, 1}, {-1, 1}})
                for (const auto &[before, after] : {std::pair(1, 1), {1, 2}, {2, 1}})
                    between = between || (inside(-before * du, -before * dv) &&
                                          inside(after * du, after * dv));
            CAPTURE(round, u);
            REQUIRE(cracks[static_cast<std::size_t>(u)] == (between && !inside(0, 0)));
        }
    }
}
