// SPDX-License-Identifier: Apache-2.0
// Kernels against the scalar code that they stand for, bit for bit, on numbers as they come and on
// those that kernels get wrong.
#include "core/base/image.hpp"
#include "core/surface/crack_kernels.hpp"
#include "core/surface/cracks.hpp"
#include "core/surface/smoothing_kernels.hpp"
#include "core/surface/surface_kernels.hpp"
#include "core/surface/surface_point.hpp"
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
/// What the kernels take for six sigmas: fixed-point products, for noise whose factors are below 1.
int six_sigmas(int z, const DepthUnits &units) {
    const auto share = [](float of_one) { return static_cast<int>(std::lround(32768 * of_one)); };
    const int curve =
        fixed_point(z, share(6 * sensor.linear)) +
        fixed_point(fixed_point(z, z), share(6 * sensor.quadratic_per_m * units.metres() * 32768));
    const int sigmas =
        std::max(static_cast<int>(std::lround(6 * sensor.floor_m * units.per_metre())) + curve,
                 fixed_point(z, share(6 * sensor.least_relative)));
    return std::min(sigmas, 32767);
}
/// Adds opposite pixels that are on the surface of the one between them.
void add_pair(int z, int a, int b, int limit, int &sum, int &pairs) {
    const int difference = a + b - 2 * z;
    if (a == 0 || b == 0 || difference < -limit || difference >= limit)
        return;
    sum += difference;
    ++pairs;
}
int pair_limit(int z, const DepthUnits &units) {
    return std::min({six_sigmas(z, units), z - fixed_point(z, 3277), 32767 / 17});
}

} // namespace

TEST_CASE("smoothing in vectors is smoothing one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(1);
    for (const float farthest : {12.0f, 30.0f})
        for (const int radius : {1, 2, 3, 8})
            for (const int count : {1, 3, 4, 7, 16, 61}) {
                const DepthUnits units(farthest);
                const int stride = count + 2 * radius, rows = 2 * radius + 1;
                const auto map = unit_depths(
                    random, static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows),
                    units);
                const UnitDepth *row = map.data() + radius * stride + radius;
                std::vector<float> out(static_cast<std::size_t>(count) + 1, -1.0f);
                smooth_row({row, stride, radius, count}, SixSigmaFactors(sensor, units), units,
                           out.data());
                for (int u = 0; u < count; ++u) {
                    const int z = row[u], limit = pair_limit(z, units);
                    int sum = 0, pairs = 0;
                    for (int dv = 0; dv <= radius; ++dv)
                        for (int du = dv == 0 ? 1 : -radius; du <= radius; ++du)
                            add_pair(z, row[u - dv * stride - du], row[u + dv * stride + du], limit,
                                     sum, pairs);
                    const float mean = static_cast<float>(z) +
                                       static_cast<float>(sum) / static_cast<float>(2 * pairs + 1);
                    CAPTURE(farthest, radius, count, u, z, sum, pairs);
                    REQUIRE(out[static_cast<std::size_t>(u)] == mean * units.metres());
                }
                CHECK(out.back() == -1.0f);
            }
}

TEST_CASE("smoothing of rows and of columns in vectors is smoothing reading by reading") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(5);
    for (const float farthest : {12.0f, 30.0f})
        for (const int count : {least_of_pass, 33, 47, 63, 64, 101}) {
            const DepthUnits units(farthest);
            const auto size = static_cast<std::size_t>(count);
            const auto row = unit_depths(random, size + 4, units);
            const SixSigmaFactors six_sigmas(sensor, units);
            // Of opposite readings that are on the surface of the one between them: how many count,
            // and how far their means are from it, each rounded up, quarters of a unit.
            const auto means_of = [&](const UnitDepth *at, int step, int &quarters, int &count_of) {
                const int limit = pair_limit(*at, units) / 2;
                for (const int away : {step, 2 * step}) {
                    const int a = *(at - away), b = *(at + away);
                    const int difference = (a + b + 1) / 2 - *at;
                    if (a == 0 || b == 0 || difference < -limit || difference >= limit)
                        continue;
                    quarters += 4 * difference - 1;
                    ++count_of;
                }
            };
            std::vector<std::uint16_t> across(size + 1, 77);
            std::vector<UnitDepth> limits(size + 1, 78);
            smooth_row_across(row.data() + 2, count, six_sigmas, across.data(), limits.data());
            for (std::size_t u = 0; u < size; ++u) {
                int quarters = 0, means = 0;
                means_of(row.data() + 2 + u, 1, quarters, means);
                const int shift = fixed_point(quarters, means == 2 ? 3277 : 5461);
                CAPTURE(farthest, count, u, quarters, means);
                REQUIRE(across[u] == static_cast<std::uint16_t>(row[u + 2] - 1 + shift));
                REQUIRE(limits[u] == pair_limit(row[u + 2], units) / 2);
            }
            CHECK(across.back() == 77);
            CHECK(limits.back() == 78);

            const auto rows = unit_depths(random, 5 * size, units);
            std::vector<std::uint16_t> less_one;
            for (const UnitDepth z : rows)
                less_one.push_back(static_cast<std::uint16_t>(z - 1));
            const UnitDepth *const middle = rows.data() + 2 * count;
            std::transform(middle, middle + count, limits.begin(),
                           [&](int z) { return static_cast<UnitDepth>(pair_limit(z, units) / 2); });
            std::vector<std::uint8_t> edges(size);
            for (std::uint8_t &edge : edges)
                edge = static_cast<std::uint8_t>(1 + random() % 7);
            std::vector<float> out(size + 1, -1.0f);
            smooth_row_down({less_one.data() + 2 * count, count, limits.data()}, count, units,
                            edges.data(), out.data());
            for (std::size_t u = 0; u < size; ++u) {
                int quarters = 0, means = 0;
                means_of(middle + u, count, quarters, means);
                const int mean = middle[u] + fixed_point(quarters, means == 2 ? 3277 : 5461);
                CAPTURE(farthest, count, u, quarters, means);
                REQUIRE(out[u] ==
                        with_edge_distance(static_cast<float>(mean) * units.metres(), edges[u]));
            }
            CHECK(out.back() == -1.0f);
        }
}

TEST_CASE("six sigmas of sensor noise in 16 bits are near those in floats", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    // As steps: of surfaces that nothing but noise parts.
    for (const float factor : {0.1f, 1.0f, 10.0f, 200.0f})
        for (const SensorNoise &of : {SensorNoise{}, SensorNoise{.floor_m = 0.002f,
                                                     .linear = 0.002f,
                                                     .quadratic_per_m = 0,
                                                     .least_relative = 0}}) {
            const SensorNoise noise = of.times(factor);
            for (const float farthest : {12.0f, 30.0f}) {
                const DepthUnits units(farthest);
                std::vector<UnitDepth> z;
                for (int depth = 200; depth < 32767; depth += 97)
                    z.push_back(static_cast<UnitDepth>(depth));
                const auto count = static_cast<int>(z.size());
                z.resize(z.size() + row_slack);
                std::vector<std::int16_t> steps(z.size() + row_slack);
                find_steps(z.data(), count, 0, SixSigmaFactors(noise, units), steps.data());
                for (int i = 0; i < count; ++i) {
                    const auto k = static_cast<std::size_t>(i);
                    const float exact =
                        std::min(6 * units.per_metre() *
                                     noise.sigma(units.metres() * static_cast<float>(z[k])),
                                 32767.0f);
                    CAPTURE(factor, farthest, z[k], exact);
                    // Products of large factors are rounded before they are doubled.
                    const float rounding = 3 * std::max(1.0f, factor / 4);
                    REQUIRE(std::abs(static_cast<float>(steps[k]) - exact) <
                            rounding + 0.02f * exact);
                }
            }
        }
}

TEST_CASE("smoothing takes no hole and nothing far away for a neighbour") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    // Sums of the largest depths leave 16 bits.
    const DepthUnits units(15.0f);
    const SixSigmaFactors noisy(sensor.times(16), units);
    constexpr int count = least_of_pass, stride = count + 4;
    for (const int z : {1, 200, 7000, 16384, 29999, 30000})
        for (const int other : {0, 1, 200, 16384, 30000}) {
            if (std::abs(z - other) < z / 2)
                continue;
            std::vector<UnitDepth> map(5 * stride + row_slack, static_cast<UnitDepth>(other));
            UnitDepth *row = map.data() + 2 * stride + 2;
            std::fill(row, row + count, static_cast<UnitDepth>(0));
            row[3] = static_cast<UnitDepth>(z);
            std::vector<float> out(count);
            // So noisy that a hole would lie within three sigmas.
            smooth_row({row, stride, 2, count}, noisy, units, out.data());
            CAPTURE(z, other);
            CHECK(out[3] == static_cast<float>(z) * units.metres());
            CHECK(out[4] == 0.0f);

            std::vector<std::uint16_t> across(count), less_one(map.begin(), map.end());
            std::vector<UnitDepth> limits(count);
            smooth_row_across(row, count, noisy, across.data(), limits.data());
            CHECK(across[3] == z - 1);
            CHECK(across[4] == 0xffff);
            for (std::uint16_t &depth : less_one)
                --depth;
            const std::vector<std::uint8_t> edges(count, 5);
            smooth_row_down({less_one.data() + 2 * stride + 2, stride, limits.data()}, count, units,
                            edges.data(), out.data());
            CHECK(out[3] == Approx(static_cast<float>(z) * units.metres()));
            CHECK(edge_distance_of(out[3]) == 5);
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
                load_row(row, units, z.data());
                for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
                    int depth = std::min<int>(millimetres[i], 32767 / units.per_millimetre()) *
                                units.per_millimetre();
                    if (bent)
                        depth = std::min(depth + fixed_point(depth, by_column[i] + by_row), 32767);
                    const bool ok = depth >= row.nearest && depth <= row.farthest;
                    CAPTURE(farthest, bent, count, i, depth);
                    REQUIRE(z[i] == (ok ? depth : 0));
                }
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
            find_steps(z.data(), count, rule.edge_relative, SixSigmaFactors(sensor, units),
                       steps.data());
            for (std::size_t i = 0; i < size; ++i) {
                const int relative =
                    fixed_point(z[i], static_cast<int>(std::lround(65536 * rule.edge_relative)));
                REQUIRE(steps[i] == (z[i] == 0 ? 0 : relative + six_sigmas(z[i], units)));
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

TEST_CASE("points inside a surface have depth and are on no edge", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(9);
    for (const std::size_t count : {1, 7, 8, 33, 100}) {
        std::vector<UnitDepth> z(count);
        std::vector<std::uint8_t> edge_distance(count), inside(count + 1, 9), expected;
        for (std::size_t i = 0; i < count; ++i) {
            z[i] = static_cast<UnitDepth>(random() % 3 == 0 ? 0 : random() % 32768);
            edge_distance[i] = static_cast<std::uint8_t>(1 + random() % far_from_edge);
            expected.push_back(z[i] != 0 && edge_distance[i] > 1);
        }
        expected.push_back(9);
        find_inside(z.data(), edge_distance.data(), static_cast<int>(count), inside.data());
        CHECK(inside == expected);
    }
}

TEST_CASE("cracks are filled in vectors as point by point", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(8);
    int filled = 0, parted = 0;
    for (int round = 0; round < 400; ++round) {
        const int count = 1 + static_cast<int>(random() % 70), widest = 1 + round / 2 % 2;
        const unsigned one_in = round % 2 == 0 ? 2 : 6; // is outside
        Image<std::uint8_t> inside(count + 4, 5);
        Image<float> points(count + 4, 5);
        for (float &point : points.pixels()) // two surfaces, and holes
            point = random() % 8 == 0
                        ? 0.0f
                        : with_edge_distance(1.5f + 0.01f * static_cast<float>(random() % 3) +
                                                 static_cast<float>(random() % 10 == 0),
                                             static_cast<std::uint8_t>(1 + random() % 7));
        std::ranges::transform(points.pixels(), inside.pixels().begin(), [&](float point) {
            return static_cast<std::uint8_t>(random() % one_in != 0 && point != 0);
        });
        const CrackRule rule = {widest, {0.02f, sensor}};
        Image<float> expected = points;
        for (int u = 0; u < count; ++u) {
            const std::uint8_t *const in = inside.row(2) + 2 + u;
            const float *const at = points.row(2) + 2 + u;
            float sum = 0;
            int pairs = 0;
            for_each_pair_across(
                inside.width(), widest, [&](std::ptrdiff_t offset) { return in[offset] != 0; },
                [&](std::ptrdiff_t before, std::ptrdiff_t after, float share) {
                    const float near = std::min(at[before], at[after]);
                    const float step = 0.02f * near + 3 * sensor.sigma(near);
                    if (std::abs(at[before] - at[after]) > step) {
                        ++parted;
                        return;
                    }
                    sum += at[before] + share * (at[after] - at[before]);
                    ++pairs;
                });
            if (*in != 0 || pairs == 0)
                continue;
            expected(2 + u, 2) = with_edge_distance(sum / static_cast<float>(pairs), beside_edge);
            ++filled;
        }
        fill_cracks_of_row(inside.row(2) + 2, inside.width(), count, rule, points.row(2) + 2);
        CAPTURE(round, count, widest);
        REQUIRE(points == expected);
    }
    CHECK(filled > 1000);
    CHECK(parted > 1000);
}
