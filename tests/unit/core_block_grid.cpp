// SPDX-License-Identifier: Apache-2.0
// Drawing of mapped tiles against the scalar code that it stands for.
#include "core/surface/surface_point.hpp"
#include "core/warp/block_grid.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <random>

using namespace afterglow;

namespace {

constexpr int width = 61, height = 53, size = mapped_tile_px;

/// A value of the corners at the place (x, y) of the tile.
float between(const MappedTile &tile, float MappedCorner::*of, float x, float y) {
    const MappedCorner *const corners = tile.corners;
    const float across = x / size, down = y / size;
    const float above = corners[0].*of + across * (corners[1].*of - corners[0].*of);
    const float below = corners[2].*of + across * (corners[3].*of - corners[2].*of);
    return above + down * (below - above);
}

/// Either of two pixels may be the nearest.
bool halfway(float u, float v) {
    const auto beside = [](float place) {
        return std::abs(place - std::floor(place) - 0.5f) < 1e-3f;
    };
    return beside(u) || beside(v);
}

/// A tile's readings, millimetres, and edge distances, at the left of a wider image.
struct DrawnTile {
    static constexpr int beside = 5;
    DepthMap reading{size + beside, size, 7};
    Image<std::uint8_t> edge{size + beside, size, 77};
    int found = 0;

    DrawnTile(const MappedTile &tile, ImageView<const float> surface, int least_edge_distance) {
        BlockGrid grid(size + beside, size);
        grid.look_up(0, 0, tile, surface, least_edge_distance);
        grid.draw_even(0, reading, edge);
        found = grid.draw_uneven(0, 0, tile, surface, least_edge_distance, reading, edge);
    }
    bool nothing_beside() const {
        bool untouched = true;
        for (int y = 0; y < size; ++y)
            for (int x = size; x < size + beside; ++x)
                untouched = untouched && reading(x, y) == 7 && edge(x, y) == 77;
        return untouched;
    }
};

/// The slope of a tile's surface by columns and rows, metres per pixel.
Eigen::Vector2f slope_between(const MappedTile &tile) {
    const auto &[a, b, c, e] = tile.corners;
    const Eigen::Matrix2f diagonals{{e.u - a.u, e.v - a.v}, {c.u - b.u, c.v - b.v}};
    const Eigen::Vector2f slope = diagonals.inverse() * Eigen::Vector2f(e.z - a.z, c.z - b.z);
    return slope.cwiseMax(-0.03f * a.z).cwiseMin(0.03f * a.z);
}

/// The depth, metres, at the place (u, v) of a surface whose nearest point is `point`, and which is
/// seen where the place (u, v) + `parallax` is.
float depth_between(ImageView<const float> surface, float u, float v, float point,
                    const Eigen::Vector2f &parallax) {
    const int left = std::clamp(static_cast<int>(u), 0, surface.width() - 2);
    const int top = std::clamp(static_cast<int>(v), 0, surface.height() - 2);
    const float a = surface(left, top), b = surface(left + 1, top);
    const float c = surface(left, top + 1), e = surface(left + 1, top + 1);
    if (std::min({a, b, c, e}) == 0.0f || edge_distance_of(point) <= beside_edge)
        return point;
    const float x = u - static_cast<float>(left) - parallax.x();
    const float y = v - static_cast<float>(top) - parallax.y();
    return std::clamp(std::lerp(std::lerp(a, b, x), std::lerp(c, e, x), y), 0.97f * point,
                      1.03f * point);
}

/// Whether the pixels of a block's row show points that are beside each other.
bool shows_rows(const MappedTile &tile) {
    constexpr float most = size / 3.0f, border = 3;
    bool rows = !tile.searched;
    for (int i = 0; i < 4; ++i) {
        const MappedCorner &corner = tile.corners[i];
        rows = rows && corner.u > border && corner.v > border && corner.u < width - 1 - border &&
               corner.v < height - 1 - border;
        if (i % 2 == 1)
            rows = rows && std::abs(corner.u - tile.corners[i - 1].u - size) < most &&
                   std::abs(corner.v - tile.corners[i - 1].v) < most;
    }
    return rows;
}

/// What is seen at a pixel of a tile that is looked up.
struct Seen {
    float reading = 0;       ///< millimetres
    int edge = 0;            ///< pixels, 0: nothing
    float inverse_depth = 0; ///< of the point, if it was searched for, 1/m
    bool uncertain = false;  ///< rounding decides
    bool beyond = false;     ///< outside the surface's picture
    bool missed = false;     ///< searched for, but not there
    bool of_row = false;     ///< loaded with those beside it
};

/// `node`: with the depth between the points around it; else with that of its point.
Seen look_up(const MappedTile &tile, ImageView<const float> surface, int least_edge_distance, int x,
             int y, bool node) {
    const Eigen::Vector2f parallax(tile.parallax_u, tile.parallax_v);
    const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
    const bool of_row = !node && shows_rows(tile);
    const auto in_row = static_cast<float>(x % mapped_block_px);
    const float middle = fx - in_row + 1.5f;
    Eigen::Vector2f place(between(tile, &MappedCorner::u, of_row ? middle : fx, fy),
                          between(tile, &MappedCorner::v, of_row ? middle : fx, fy));
    if (of_row)
        place.x() += in_row - 1.5f;
    Seen seen;
    seen.uncertain = halfway(place.x(), place.y());
    float inverse = tile.inverse_depth;
    if (tile.searched) {
        const int u = std::clamp(static_cast<int>(place.x() + 0.5f), 0, width - 1);
        const int v = std::clamp(static_cast<int>(place.y() + 0.5f), 0, height - 1);
        inverse = surface(u, v) == 0 ? tile.farthest_inverse_depth : 1 / surface(u, v);
        place -= (inverse - tile.inverse_depth) * parallax;
        seen.uncertain = seen.uncertain || halfway(place.x(), place.y());
    }
    seen.inverse_depth = inverse;
    const int u = static_cast<int>(std::floor(place.x() + 0.5f));
    const int v = static_cast<int>(std::floor(place.y() + 0.5f));
    seen.beyond = !surface.contains(u, v);
    // Just before the first column or row it may be taken for that.
    seen.uncertain = seen.uncertain || (seen.beyond && (u == -1 || v == -1));
    const float point = seen.beyond ? 0 : surface(u, v);
    if (point == 0)
        return seen;
    const Eigen::Vector2f moved = (1 / point - inverse) * parallax;
    if (tile.searched) {
        const float off_px = moved.lpNorm<1>();
        seen.uncertain = seen.uncertain || std::abs(off_px - 3) < 0.01f;
        seen.missed = !(off_px < 3);
    }
    if (seen.missed || edge_distance_of(point) < least_edge_distance)
        return seen;
    const Eigen::Vector2f beside(place.x() - static_cast<float>(u),
                                 place.y() - static_cast<float>(v));
    float depth = point;
    seen.of_row = of_row;
    if (node)
        depth = tile.one_surface ? point + slope_between(tile).dot(beside)
                                 : depth_between(surface, place.x(), place.y(), point, moved);
    seen.reading = depth * between(tile, &MappedCorner::scale, fx, fy) +
                   between(tile, &MappedCorner::shift, fx, fy);
    seen.edge = edge_distance_of(point);
    return seen;
}

/// How many blocks of each kind, and pixels, were compared.
struct Compared {
    int even = 0, uneven = 0, seen = 0, missed = 0, beyond = 0, of_rows = 0;
};

/// Requires that a tile is drawn as it should be.
void compare(const MappedTile &tile, ImageView<const float> surface, int least_edge_distance,
             Compared &compared) {
    constexpr int step = mapped_block_px;
    const DrawnTile drawn(tile, surface, least_edge_distance);
    REQUIRE(drawn.nothing_beside());
    int there = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            there += drawn.edge(x, y) != 0;
    REQUIRE(drawn.found == there);
    const auto at = [&](int x, int y, bool node = true) {
        return look_up(tile, surface, least_edge_distance, x, y, node);
    };
    for (int top = 0; top < size; top += step)
        for (int left = 0; left < size; left += step) {
            const Seen corners[] = {at(left, top), at(left + step, top), at(left, top + step),
                                    at(left + step, top + step)};
            int least_edge = 7, sum = 0;
            float least = 1e9f, most = -1e9f;
            bool uncertain = false;
            for (const Seen &corner : corners) {
                uncertain = uncertain || corner.uncertain;
                least_edge = std::min(least_edge, corner.edge);
                sum += corner.edge;
                least = std::min(least, corner.inverse_depth);
                most = std::max(most, corner.inverse_depth);
            }
            const float apart =
                (most - least) * (std::abs(tile.parallax_u) + std::abs(tile.parallax_v));
            if (uncertain || (tile.searched && std::abs(apart - alike_displacement_px) < 1e-3f))
                continue;
            const bool even = tile.interpolated && least_edge >= edge_free_block &&
                              !(tile.searched && apart >= alike_displacement_px);
            compared.even += even;
            compared.uneven += !even;
            for (int y = top; y < top + step; ++y)
                for (int x = left; x < left + step; ++x) {
                    const auto reading = static_cast<float>(drawn.reading(x, y));
                    CAPTURE(x, y, even, sum);
                    if (even) {
                        const float across = static_cast<float>(x - left) / step;
                        const float down = static_cast<float>(y - top) / step;
                        const float expected = std::lerp(
                            std::lerp(corners[0].reading, corners[1].reading, across),
                            std::lerp(corners[2].reading, corners[3].reading, across), down);
                        REQUIRE(std::abs(reading - expected) <= 1.6f); // rounded thrice
                        REQUIRE(drawn.edge(x, y) == sum / 4);
                        continue;
                    }
                    const Seen seen = at(x, y, false);
                    if (seen.uncertain)
                        continue;
                    REQUIRE(std::abs(reading - seen.reading) < 0.51f);
                    REQUIRE(drawn.edge(x, y) == seen.edge);
                    compared.seen += seen.edge != 0;
                    compared.missed += seen.missed;
                    compared.beyond += seen.beyond;
                    compared.of_rows += seen.of_row;
                }
        }
}

/// Puts a tile's corners on a square at (left, top), each up to `most_moved` pixels beside its
/// place, with a scale and a shift of its own from depths, metres, to readings, millimetres.
void place_corners(MappedTile &tile, float left, float top, float most_moved,
                   std::mt19937 &random) {
    std::uniform_real_distribution<float> some(-1.0f, 1.0f);
    for (int i = 0; i < 4; ++i) {
        MappedCorner &corner = tile.corners[i];
        corner.u = left + size * static_cast<float>(i & 1) + most_moved * some(random);
        corner.v = top + size * static_cast<float>(i >> 1) + most_moved * some(random);
        corner.scale = 1000.0f + 100.0f * some(random);
        corner.shift = 100.0f * some(random);
    }
}

} // namespace

TEST_CASE("a mapped tile shows depths between the corners of even blocks, and nearest points in "
          "uneven ones") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> some(-1.0f, 1.0f), depths(0.5f, 4.0f);
    Compared compared;
    for (int round = 0; round < 200; ++round) {
        Image<float> surface(width, height); // with steps, edges and holes
        for (float &z : surface.pixels())
            z = random() % 7 == 0 ? 0.0f
                                  : with_edge_distance(depths(random),
                                                       static_cast<std::uint8_t>(1 + random() % 7));
        MappedTile tile;
        tile.one_surface = round % 5 != 0;
        tile.interpolated = round % 7 != 0;
        if (!tile.one_surface) {
            tile.inverse_depth = 0.5f;
            tile.parallax_u = some(random);
            tile.parallax_v = some(random);
        }
        const bool in_picture = round % 2 == 0;
        const float left = in_picture ? 15 : -5, top = in_picture ? 13 : 45;
        const float most_moved = round % 4 == 0 ? 2 : 5;
        place_corners(tile, left, top, most_moved, random);
        for (MappedCorner &corner : tile.corners)
            corner.z = 2.0f + 0.2f * some(random);
        CAPTURE(round);
        compare(tile, surface, 1 + round % 3, compared);
    }
    CHECK(compared.even > 100);
    CHECK(compared.uneven > 1000);
    CHECK(compared.beyond > 100);
    CHECK(compared.of_rows > 1000);
}

TEST_CASE("a mapped tile whose points are searched for shows those that are seen there") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(9);
    std::uniform_real_distribution<float> some(-1.0f, 1.0f), slope(-0.02f, 0.02f);
    Compared compared;
    for (int round = 0; round < 200; ++round) {
        Image<float> surface(width, height); // two planes, one beside the other, with holes
        const float by_u = slope(random), by_v = slope(random);
        const int border = 20 + static_cast<int>(random() % 20);
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u)
                surface(u, v) =
                    random() % 19 == 0
                        ? 0.0f
                        : with_edge_distance((u < border ? 1.0f : 2.5f) +
                                                 by_u * static_cast<float>(u) +
                                                 by_v * static_cast<float>(v),
                                             static_cast<std::uint8_t>(1 + random() % 7));
        MappedTile tile;
        tile.one_surface = false;
        tile.searched = true;
        tile.inverse_depth = 1.2f;
        tile.farthest_inverse_depth = 0.3f;
        tile.parallax_u = 7 * some(random);
        tile.parallax_v = 4 * some(random);
        const bool in_picture = round % 2 == 0;
        const float left = in_picture ? 20 : -5, top = in_picture ? 16 : 45;
        place_corners(tile, left, top, 3, random);
        for (MappedCorner &corner : tile.corners)
            corner.z = 1 / tile.inverse_depth;
        CAPTURE(round);
        compare(tile, surface, 1 + round % 3, compared);
    }
    CHECK(compared.seen > 5000);
    CHECK(compared.missed > 100);
    CHECK(compared.even > 100);
    CHECK(compared.uneven > 1000);
}

TEST_CASE(
    "a mapped tile whose pixels are 10^12 pixels away from the surface's picture shows nothing") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(11);
    const Image<float> surface(width, height, with_edge_distance(2.0f, far_from_edge));
    for (const bool one_surface : {true, false})
        for (const bool searched : {true, false})
            for (const float away : {-1e12f, 1e12f}) {
                if (one_surface && searched)
                    continue;
                MappedTile tile;
                tile.one_surface = one_surface;
                tile.searched = searched;
                tile.inverse_depth = 0.5f;
                tile.farthest_inverse_depth = 0.3f;
                tile.parallax_u = tile.parallax_v = 3;
                for (const bool across : {true, false}) {
                    place_corners(tile, across ? away : 20, across ? 16 : away, 1, random);
                    for (MappedCorner &corner : tile.corners)
                        corner.z = 2;
                    const DrawnTile drawn(tile, surface, 1);
                    CAPTURE(one_surface, searched, away, across);
                    CHECK(drawn.found == 0);
                    for (int y = 0; y < size; ++y)
                        for (int x = 0; x < size; ++x)
                            REQUIRE((drawn.reading(x, y) == 0 && drawn.edge(x, y) == 0));
                }
            }
}

TEST_CASE("a block of a tile whose corners are of two surfaces is not drawn between them") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    Image<float> surface(width, height);
    constexpr int border = 28; // in the middle of a block
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            const int distance = u < border ? border - u : u - border + 1;
            surface(u, v) = with_edge_distance(
                u < border ? 1 : 2, static_cast<std::uint8_t>(std::min(distance, far_from_edge)));
        }
    for (const bool searched : {false, true}) {
        MappedTile tile;
        tile.one_surface = false;
        tile.searched = searched;
        tile.inverse_depth = searched ? 1.0f : 0.75f;
        tile.farthest_inverse_depth = 0.5f;
        tile.parallax_u = 1;
        for (int i = 0; i < 4; ++i)
            tile.corners[i] = {static_cast<float>(18 + size * (i & 1)),
                               static_cast<float>(16 + size * (i >> 1)), 1 / tile.inverse_depth,
                               1000, 0};
        const DrawnTile drawn(tile, surface, 1);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                CAPTURE(searched, x, y);
                REQUIRE((drawn.reading(x, y) == 1000 || drawn.reading(x, y) == 2000 ||
                         (searched && drawn.reading(x, y) == 0)));
            }
    }
}
