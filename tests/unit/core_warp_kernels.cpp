// SPDX-License-Identifier: Apache-2.0
// Kernels of the warp against the scalar code that they stand for.
#include "core/calibration/self_calibration.hpp"
#include "core/surface/surface_point.hpp"
#include "core/warp/mapped_tile.hpp"
#include "core/warp/surface_projection.hpp"
#include "core/warp/warp_kernels.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace afterglow;

namespace {

/// Points with steps, edges and holes, metres.
std::vector<float> broken_depths(std::mt19937 &random, std::size_t count) {
    std::uniform_real_distribution<float> any(0.5f, 4.0f);
    std::vector<float> z;
    for (std::size_t i = 0; i < count; ++i)
        z.push_back(random() % 7 == 0 ? 0.0f
                                      : with_edge_distance(any(random), static_cast<std::uint8_t>(
                                                                            1 + random() % 7)));
    return z;
}

} // namespace

TEST_CASE("warped pixels become the same readings in vectors as one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(4);
    std::uniform_real_distribution<float> any(0.0f, warped_farthest_m);
    std::uniform_int_distribution<int> edge(0, warped_edge_mask);
    for (const bool corrected : {false, true}) {
        DepthCorrection correction;
        if (corrected)
            correction.shape = {-0.02f, 0.01f, 0.03f};
        std::vector<WarpedPixel> pixels{0, warped_edge_mask};
        while (pixels.size() < 61)
            pixels.push_back(
                (static_cast<WarpedPixel>(any(random) * warped_units_per_m) << warped_depth_shift) |
                edge(random));
        const auto count = static_cast<int>(pixels.size());
        const auto scale = [&](int i) {
            return correction.scale(-0.566f + 0.002f * static_cast<float>(i), -0.2f);
        };
        const float first = 1 / scale(0), end = 1 / scale(count);
        const WarpedRow row = {pixels.data(), count, first,
                               (end - first) / static_cast<float>(count)};
        std::vector<std::uint16_t> millimetres(pixels.size());
        std::vector<std::uint8_t> edges(pixels.size(), 99);
        const int found = find_readings(row, millimetres.data(), edges.data());
        CHECK(found == count - 1);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const float reading = warped_z(pixels[i]) / scale(static_cast<int>(i));
            CAPTURE(corrected, i, reading);
            // Between the ends the correction is not quite linear.
            CHECK(std::abs(millimetres[i] - static_cast<int>(reading * 1000.0f + 0.5f)) <=
                  (corrected ? 3 : 0));
            CHECK(edges[i] == (pixels[i] & warped_edge_mask));
        }
    }
}

TEST_CASE("pieces of a surface are looked for on the tiles of the view that show their points") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(6);
    constexpr int px = 4, count = 13, columns = 10, lines = 7;
    const Intrinsics from{45, 47, 26, 19.5, 53, 40};
    const Intrinsics to{130, 131, 77, 55, columns * mapped_tile_px - 3, lines * mapped_tile_px - 5};
    std::uniform_real_distribution<float> some(-1.0f, 1.0f), any(0.3f, 4.0f);
    int seen_pieces = 0, hidden_pieces = 0, everywhere = 0;
    for (int round = 0; round < 200; ++round) {
        Pose pose;
        pose.R = Eigen::AngleAxisd(0.3 * some(random), Eigen::Vector3d::Random().normalized())
                     .toRotationMatrix();
        pose.T = {0.2 * some(random), 0.2 * some(random), 0.8 * some(random)};
        RollingShutter shutter;
        if (round % 2 == 1)
            shutter.motion << 0.02 * Twist::Random();
        const SurfaceProjection projection(from, to, pose, shutter);
        std::array<float, count> nearest{}, farthest{};
        for (std::size_t i = 0; i < count; ++i) {
            if (random() % 5 == 0)
                continue;
            nearest[i] = any(random);
            farthest[i] = nearest[i] * (1 + 0.5f * std::abs(some(random)));
        }
        const float v = static_cast<float>(random() % 36) + 1.5f;
        const float behind = 0.15f, margin = round % 3 == 0 ? 3 : 0.25f;
        std::array<TileRange, count> ranges{};
        find_tile_ranges({nearest.data(), farthest.data(), 1.5f, px, count},
                         {projection.row(v), projection.while_read(), projection.turn(), behind,
                          columns, lines, margin},
                         ranges.data());
        for (std::size_t i = 0; i < count; ++i) {
            const TileRange &range = ranges[i];
            const bool on_none = range.left > range.right || range.top > range.bottom;
            CAPTURE(round, i, nearest[i], farthest[i]);
            if (nearest[i] == 0) {
                REQUIRE(on_none);
                continue;
            }
            int in_front = 0;
            for (const float z : {nearest[i], farthest[i]}) {
                const float u = static_cast<float>(i) * px + 1.5f;
                const Eigen::Vector3f middle = projection(u, v, z);
                if (!(middle.z() > behind))
                    continue;
                ++in_front;
                // A pixel of the view at a corner of the piece is on one of its tiles.
                // By how much a point moves in the view with its pixel on the surface.
                const Eigen::Matrix3f &turn = projection.turn();
                const Eigen::Matrix2f J =
                    z / middle.z() *
                    (turn.topLeftCorner<2, 2>() - middle.head<2>() * turn.row(2).head<2>());
                for (const float du : {-0.5f * px, 0.0f, 0.5f * px})
                    for (const float dv : {-0.5f * px, 0.0f, 0.5f * px}) {
                        const Eigen::Vector2f at = middle.head<2>() + J * Eigen::Vector2f(du, dv);
                        const float size = mapped_tile_px, reach = margin - 0.01f;
                        // At both ends of what the margin reaches.
                        for (const float way : {-reach, reach}) {
                            const float x = at.x() + way, y = at.y() + way;
                            if (!(x >= 0 && y >= 0 && x < size * columns && y < size * lines))
                                continue;
                            const int tx = static_cast<int>(x / size);
                            const int ty = static_cast<int>(y / size);
                            REQUIRE((range.left <= tx && tx <= range.right));
                            REQUIRE((range.top <= ty && ty <= range.bottom));
                        }
                    }
            }
            seen_pieces += !on_none;
            hidden_pieces += on_none;
            if (in_front == 0)
                REQUIRE(on_none);
            if (in_front != 1)
                continue;
            ++everywhere;
            REQUIRE((range.left == 0 && range.top == 0));
            REQUIRE((range.right == columns - 1 && range.bottom == lines - 1));
        }
    }
    CHECK(seen_pieces > 300);
    CHECK(hidden_pieces > 100);
    CHECK(everywhere > 5);
}

TEST_CASE("a surface's points land on the pixels of the view that they are projected to") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(5);
    constexpr int width = 40, height = 30, count = 40;
    const RowMotion still = {Eigen::Matrix3f::Zero(), Eigen::Vector3f::Zero(), 0, 0, false};
    const LandingLimits limits = {0.1f, 12.0f, width, height, 2, 0, width};
    std::uniform_real_distribution<float> shift(-30.0f, 30.0f), along(-1.5f, 1.5f);
    for (int round = 0; round < 200; ++round) {
        const auto padded = broken_depths(random, count + 2);
        const auto above = broken_depths(random, count), below = broken_depths(random, count);
        const RowProjection by = {{1.0f, along(random) * 0.1f, along(random) * 0.01f},
                                  {shift(random), shift(random), along(random)},
                                  {shift(random) * 0.1f, shift(random) * 0.1f, along(random)}};
        std::vector<int> offsets(count);
        std::vector<WarpedPixel> values(count);
        project_points({padded.data(), above.data(), below.data(), 0, count}, by, still, limits,
                       offsets.data(), values.data());
        for (int u = 0; u < count; ++u) {
            const auto i = static_cast<std::size_t>(u);
            const float z = padded[i + 1];
            const auto along_axis = [&](int k) {
                return z * (by.by_column[k] * static_cast<float>(u) + by.origin[k]) + by.shift[k];
            };
            const float depth = along_axis(2), x = along_axis(0) / depth + 0.5f,
                        y = along_axis(1) / depth + 0.5f;
            // A division may be off by a few units in the last place.
            const auto close = [](float a, float b) { return std::abs(a - b) < 1e-4f; };
            if (close(x, 0) || close(x, width) || close(y, 0) || close(y, height) ||
                close(x, std::round(x)) || close(y, std::round(y)))
                continue;
            const bool lands = edge_distance_of(z) >= limits.least_edge_distance &&
                               depth > limits.nearest && depth < limits.farthest && x >= 0 &&
                               x < width && y >= 0 && y < height;
            CAPTURE(round, u, z, depth, x, y);
            REQUIRE((values[i] != nothing_landed) == lands);
            if (lands)
                REQUIRE(offsets[i] == static_cast<int>(y) * width + static_cast<int>(x));
        }
    }
}

TEST_CASE(
    "a warped pixel may be a crack if it is empty beside others, or lies behind both neighbours") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(6);
    constexpr int count = 37;
    const auto row = [&] {
        std::vector<WarpedPixel> pixels;
        for (int i = 0; i < count + 2; ++i)
            pixels.push_back(random() % 3 != 0
                                 ? nothing_landed
                                 : static_cast<WarpedPixel>((20000 + 3000 * (random() % 3))
                                                            << warped_depth_shift));
        return pixels;
    };
    for (int round = 0; round < 50; ++round) {
        const auto above = row(), here = row(), below = row();
        std::vector<WarpedPixel> out(count);
        std::vector<std::uint8_t> doubtful(count, 9);
        find_doubtful({above.data() + 1, here.data() + 1, below.data() + 1, count}, out.data(),
                      doubtful.data());
        for (std::size_t i = 1; i <= count; ++i) {
            const bool empty = here[i] == nothing_landed;
            bool lonely = true;
            for (const auto *of : {&above, &here, &below})
                for (std::size_t k = i - 1; k <= i + 1; ++k)
                    lonely = lonely && ((of == &here && k == i) || (*of)[k] == nothing_landed);
            const WarpedPixel next = std::min(here[i - 1], here[i + 1]);
            const bool behind = !empty && next <= here[i] - (here[i] >> 5);
            CAPTURE(round, i);
            REQUIRE(out[i - 1] == (empty ? 0 : here[i]));
            REQUIRE(int{doubtful[i - 1]} == ((empty && !lonely) || behind));
        }
    }
}

TEST_CASE("parts of a surface are added to tiles in vectors as one by one") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(8);
    constexpr int columns = 7, rows = 5;
    for (int round = 0; round < 50; ++round) {
        std::vector<SurfacePart> parts;
        std::vector<TileRange> ranges;
        for (int i = 0; i < 60; ++i) {
            const float nearest = 0.5f + 0.01f * static_cast<float>(random() % 300);
            parts.emplace_back(nearest, nearest + 0.1f * static_cast<float>(random() % 9),
                               1 + static_cast<int>(random() % 7), random() % 5 == 0);
            if (i > 0 && random() % 3 == 0) {
                ranges.push_back(ranges.back()); // on the same tiles as the part before
                continue;
            }
            const auto some = [&](int most) {
                return static_cast<std::int16_t>(random() % static_cast<unsigned>(most));
            };
            ranges.push_back({some(columns), some(columns), some(rows), some(rows)});
        }
        Image<SurfacePart> tiles(columns, rows), expected = tiles;
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (int y = ranges[i].top; y <= ranges[i].bottom; ++y)
                for (int x = ranges[i].left; x <= ranges[i].right; ++x)
                    expected(x, y).add(parts[i]);
        add_to_tiles(parts.data(), ranges, tiles);
        for (std::size_t i = 0; i < tiles.pixels().size(); ++i)
            REQUIRE(tiles.pixels()[i].most() == expected.pixels()[i].most());
    }
}
