// SPDX-License-Identifier: Apache-2.0
// Drawing of mapped tiles against the scalar code that it stands for.
#include "core/keyframe/mapped_tile.hpp"
#include "core/keyframe/surface_point.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

using namespace afterglow;

namespace {

constexpr int width = 61, height = 53, size = mapped_tile_px;

/// A value of the corners at the pixel (x, y) of the tile.
float between(const MappedTile &tile, float MappedCorner::*of, int x, int y) {
    const MappedCorner *const corners = tile.corners;
    const float across = static_cast<float>(x) / size, down = static_cast<float>(y) / size;
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
        found = draw_mapped(tile, surface, least_edge_distance,
                            ImageView(reading.row(0), size, size, reading.width()),
                            ImageView(edge.row(0), size, size, edge.width()));
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

} // namespace

TEST_CASE("a mapped tile of the view shows the nearest points of the surface, moved along its "
          "slope") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> some(-1.0f, 1.0f), depths(0.5f, 4.0f);
    for (int round = 0; round < 200; ++round) {
        Image<float> surface(width, height); // with steps, edges and holes
        for (float &z : surface.pixels())
            z = random() % 7 == 0 ? 0.0f
                                  : with_edge_distance(depths(random),
                                                       static_cast<std::uint8_t>(1 + random() % 7));
        MappedTile tile;
        tile.one_surface = round % 5 != 0;
        tile.in_picture = round % 2 == 0;
        if (!tile.one_surface) {
            tile.inverse_depth = 0.5f;
            tile.parallax_u = some(random);
            tile.parallax_v = some(random);
        }
        const float left = tile.in_picture ? 15 : -5, top = tile.in_picture ? 13 : 45;
        for (int i = 0; i < 4; ++i)
            tile.corners[i] = {left + size * static_cast<float>(i & 1) + 5 * some(random),
                               top + size * static_cast<float>(i >> 1) + 5 * some(random),
                               2.0f + 0.2f * some(random), 1000.0f + 100.0f * some(random),
                               100.0f * some(random)};
        const int least_edge_distance = 1 + round % 3;
        const DrawnTile drawn(tile, surface, least_edge_distance);
        const Eigen::Vector2f of_tile = slope_between(tile);
        int there = 0, beyond = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                there += drawn.edge(x, y) != 0;
                const float u = between(tile, &MappedCorner::u, x, y);
                const float v = between(tile, &MappedCorner::v, x, y);
                if (halfway(u, v))
                    continue;
                const int nu = static_cast<int>(std::floor(u + 0.5f));
                const int nv = static_cast<int>(std::floor(v + 0.5f));
                // Just before the first column or row it may be taken for that.
                if ((nu == -1 || nv == -1) && !tile.in_picture)
                    continue;
                beyond += !surface.view().contains(nu, nv);
                const float depth = surface.view().contains(nu, nv) ? surface(nu, nv) : 0;
                CAPTURE(round, x, y, u, v);
                if (edge_distance_of(depth) < least_edge_distance) {
                    REQUIRE((drawn.reading(x, y) == 0 && drawn.edge(x, y) == 0));
                    continue;
                }
                const float nearer = 1 / depth - tile.inverse_depth;
                const Eigen::Vector2f beside(u - static_cast<float>(nu),
                                             v - static_cast<float>(nv));
                const float moved =
                    tile.one_surface
                        ? depth + of_tile.dot(beside)
                        : depth_between(surface, u, v, depth,
                                        nearer * Eigen::Vector2f(tile.parallax_u, tile.parallax_v));
                const float reading = moved * between(tile, &MappedCorner::scale, x, y) +
                                      between(tile, &MappedCorner::shift, x, y);
                REQUIRE(std::abs(static_cast<float>(drawn.reading(x, y)) - reading) < 0.51f);
                REQUIRE(drawn.edge(x, y) == edge_distance_of(depth));
            }
        REQUIRE(drawn.found == there);
        REQUIRE((beyond > 0) == !tile.in_picture);
        REQUIRE(drawn.nothing_beside());
    }
}

TEST_CASE("a mapped tile whose points are searched for shows those that are seen there") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(9);
    std::uniform_real_distribution<float> some(-1.0f, 1.0f), slope(-0.02f, 0.02f);
    int seen = 0, missed = 0;
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
        tile.in_picture = round % 2 == 0;
        tile.inverse_depth = 1.2f;
        tile.farthest_inverse_depth = 0.3f;
        tile.parallax_u = 7 * some(random);
        tile.parallax_v = 4 * some(random);
        const float left = tile.in_picture ? 20 : -5, top = tile.in_picture ? 16 : 45;
        for (int i = 0; i < 4; ++i)
            tile.corners[i] = {left + size * static_cast<float>(i & 1) + 3 * some(random),
                               top + size * static_cast<float>(i >> 1) + 3 * some(random),
                               1 / tile.inverse_depth, 1000.0f + 100.0f * some(random),
                               100.0f * some(random)};
        const int least_edge_distance = 1 + round % 3;
        const DrawnTile drawn(tile, surface, least_edge_distance);
        const Eigen::Vector2f parallax(tile.parallax_u, tile.parallax_v);
        int there = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                there += drawn.edge(x, y) != 0;
                const Eigen::Vector2f first(between(tile, &MappedCorner::u, x, y),
                                            between(tile, &MappedCorner::v, x, y));
                Eigen::Vector2f place = first;
                float inverse = tile.inverse_depth;
                bool uncertain = halfway(place.x(), place.y());
                for (int step = 0; step < 2; ++step) {
                    const int u = std::clamp(static_cast<int>(place.x() + 0.5f), 0, width - 1);
                    const int v = std::clamp(static_cast<int>(place.y() + 0.5f), 0, height - 1);
                    inverse = surface(u, v) == 0 ? tile.farthest_inverse_depth : 1 / surface(u, v);
                    place = first - (inverse - tile.inverse_depth) * parallax;
                    uncertain = uncertain || halfway(place.x(), place.y());
                }
                const int nu = static_cast<int>(std::floor(place.x() + 0.5f));
                const int nv = static_cast<int>(std::floor(place.y() + 0.5f));
                const bool beyond = !surface.view().contains(nu, nv);
                if (uncertain || (beyond && (nu == -1 || nv == -1)))
                    continue;
                const float point = beyond ? 0 : surface(nu, nv);
                const Eigen::Vector2f moved = (1 / point - inverse) * parallax;
                const float off_px = moved.lpNorm<1>();
                CAPTURE(round, x, y, place.x(), place.y(), off_px);
                if (std::abs(off_px - 3) < 0.01f)
                    continue;
                if (!(off_px < 3) || edge_distance_of(point) < least_edge_distance) {
                    missed += point != 0 && !(off_px < 3);
                    REQUIRE((drawn.reading(x, y) == 0 && drawn.edge(x, y) == 0));
                    continue;
                }
                ++seen;
                const float depth = depth_between(surface, place.x(), place.y(), point, moved);
                const float reading = depth * between(tile, &MappedCorner::scale, x, y) +
                                      between(tile, &MappedCorner::shift, x, y);
                REQUIRE(std::abs(static_cast<float>(drawn.reading(x, y)) - reading) < 0.51f);
                REQUIRE(drawn.edge(x, y) == edge_distance_of(point));
            }
        REQUIRE(drawn.found == there);
        REQUIRE(drawn.nothing_beside());
    }
    CHECK(seen > 10000);
    CHECK(missed > 100);
}

TEST_CASE("of a tile of an even surface every fourth pixel is looked up, unless one is a hole or "
          "near an edge") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(8);
    std::uniform_real_distribution<float> some(-1.0f, 1.0f);
    constexpr int step = 4, least_edge_distance = 3;
    for (int round = 0; round < 100; ++round) {
        Image<float> surface(width, height);
        for (float &z : surface.pixels())
            z = with_edge_distance(2 + 0.1f * some(random), far_from_edge);
        MappedTile tile;
        tile.even = true;
        for (int i = 0; i < 4; ++i)
            tile.corners[i] = {15 + size * static_cast<float>(i & 1) + 5 * some(random),
                               13 + size * static_cast<float>(i >> 1) + 5 * some(random), 2.0f,
                               1000.0f + 100.0f * some(random), 100.0f * some(random)};
        const auto nearest = [&](int x, int y) {
            const float u = between(tile, &MappedCorner::u, x, y);
            const float v = between(tile, &MappedCorner::v, x, y);
            return std::pair(static_cast<int>(u + 0.5f), static_cast<int>(v + 0.5f));
        };
        const auto reading = [&](int x, int y) {
            const auto [u, v] = nearest(x, y);
            return surface(u, v) * between(tile, &MappedCorner::scale, x, y) +
                   between(tile, &MappedCorner::shift, x, y);
        };
        const auto uncertain = [&](int x, int y) {
            return halfway(between(tile, &MappedCorner::u, x, y),
                           between(tile, &MappedCorner::v, x, y));
        };
        const DrawnTile drawn(tile, surface, least_edge_distance);
        REQUIRE(drawn.found == size * size);
        REQUIRE(drawn.nothing_beside());
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const int left = x / step * step, top = y / step * step;
                const int right = left + step, bottom = top + step;
                CAPTURE(round, x, y);
                REQUIRE(drawn.edge(x, y) == far_from_edge);
                if (uncertain(left, top) || uncertain(right, top) || uncertain(left, bottom) ||
                    uncertain(right, bottom))
                    continue;
                const float across = static_cast<float>(x - left) / step;
                const float down = static_cast<float>(y - top) / step;
                const float above = std::lerp(reading(left, top), reading(right, top), across);
                const float below =
                    std::lerp(reading(left, bottom), reading(right, bottom), across);
                const float expected = std::lerp(above, below, down);
                REQUIRE(std::abs(static_cast<float>(drawn.reading(x, y)) - expected) < 0.52f);
            }

        const auto [u, v] = nearest(size / 2, size / 4);
        for (int dv = -1; dv <= 1; ++dv)
            for (int du = -1; du <= 1; ++du)
                surface(u + du, v + dv) = round % 2 == 0 ? 0 : with_edge_distance(2, 4);
        const DrawnTile again(tile, surface, least_edge_distance);
        tile.even = false;
        const DrawnTile pixel_by_pixel(tile, surface, least_edge_distance);
        REQUIRE(again.found == pixel_by_pixel.found);
        REQUIRE((again.found < size * size) == (round % 2 == 0));
        REQUIRE(again.reading == pixel_by_pixel.reading);
        REQUIRE(again.edge == pixel_by_pixel.edge);
    }
}
