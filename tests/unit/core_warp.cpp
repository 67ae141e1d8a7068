// SPDX-License-Identifier: Apache-2.0
#include "core/warp/warp.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

using namespace afterglow;

namespace {

/// A camera of an odd size, so that neither vectors nor tiles fit.
const Intrinsics camera{150, 150, 74.3, 50.8, 149, 103};

SurfaceOptions as_measured(int crack_px) {
    SurfaceOptions options;
    options.smooth_radius_px = 0;
    options.crack_px = crack_px;
    return options;
}

/// Warps a map, millimetres.
struct Carried {
    explicit Carried(const DepthMap &map, const Pose &pose, int workers = 1,
                     const WarpOptions &options = {}, const RollingShutter &shutter = {},
                     int crack_px = widest_crack_px)
        : millimetres(camera.width, camera.height, 9), edges(camera.width, camera.height, 9),
          depth(camera.width, camera.height) {
        WorkerPool pool(workers);
        DepthSurface surface(camera, as_measured(crack_px));
        surface.build(map, pool);
        Warp warp(camera, camera, options, pool);
        drawn = warp.run(surface, pose, millimetres, edges, {}, shutter);
        tiles = warp.readings();
        for (std::size_t i = 0; i < depth.pixels().size(); ++i)
            depth.pixels()[i] = 0.001f * static_cast<float>(millimetres.pixels()[i]);
    }
    /// Pixels without depth, but for `border` at all sides.
    int holes(int border) const {
        int count = 0;
        for (int v = border; v < camera.height - border; ++v)
            for (int u = border; u < camera.width - border; ++u)
                count += millimetres(u, v) == 0;
        return count;
    }
    DepthMap millimetres;
    Image<std::uint8_t> edges;
    Image<float> depth; ///< metres, 0 = none
    Image<TileReadings> tiles;
    int drawn = 0;
};

DepthMap wall(std::uint16_t mm) {
    return {camera.width, camera.height, mm};
}

/// A wall 2 m ahead with a plate of 40 x 40 pixels 1 m ahead, from column `left` and row `top` on.
DepthMap wall_and_plate(int left = 50, int top = 30) {
    DepthMap map = wall(2000);
    for (int v = top; v < top + 40; ++v)
        for (int u = left; u < left + 40; ++u)
            map(u, v) = 1000;
    return map;
}

Pose shifted(double x, double y, double z) {
    return {Eigen::Matrix3d::Identity(), {x, y, z}};
}

WarpOptions all_carried() {
    WarpOptions options;
    options.least_edge_distance_px = 1;
    return options;
}

/// Points are not searched for: single ones among holes would not be found.
WarpOptions one_by_one() {
    WarpOptions options = all_carried();
    options.edges_hide = true;
    return options;
}

} // namespace

TEST_CASE("warping a map by the identity leaves it unchanged", "[core]") {
    std::mt19937 random(1);
    DepthMap map = wall(0);
    for (std::uint16_t &mm : map.pixels())
        mm = random() % 5 == 0 ? 0 : static_cast<std::uint16_t>(1500 + random() % 20);
    const Carried carried(map, Pose::identity(), 1, all_carried(), {}, 0);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            REQUIRE(carried.depth(u, v) == Approx(0.001 * map(u, v)).margin(1e-6));
}

namespace {

/// Points 9 pixels apart, by turns near and far, so that tiles of the view show both.
DepthMap scattered_points() {
    DepthMap map = wall(0);
    for (int v = 4; v < camera.height; v += 9)
        for (int u = 4; u < camera.width; u += 9)
            map(u, v) = static_cast<std::uint16_t>(((u + v) / 9 % 2 == 0 ? 1000 : 2500) + v);
    return map;
}

/// The depth of a point where it is seen, metres, or, if nothing is there, on a pixel beside.
float shown_at(const Carried &carried, int u, int v) {
    for (const int dv : {0, -1, 1})
        for (const int du : {0, -1, 1})
            if (carried.depth.view().contains(u + du, v + dv) &&
                carried.depth(u + du, v + dv) != 0.0f)
                return carried.depth(u + du, v + dv);
    return 0;
}

} // namespace

TEST_CASE("warping moves a point to its projection and its new depth", "[core]") {
    const Pose pose{rotation({0.02, -0.03, 0.05}), {0.03, -0.02, 0.05}};
    const DepthMap map = scattered_points();
    const Carried carried(map, pose, 1, one_by_one());
    int landed = 0;
    for (int v = 4; v < camera.height; v += 9)
        for (int u = 4; u < camera.width; u += 9) {
            const Eigen::Vector3d X = pose * camera.back_project(u, v, 0.001 * map(u, v));
            const Eigen::Vector2d p = camera.project(X) + Eigen::Vector2d::Constant(0.5);
            // What lands within a thousandth of a pixel of two of them may go to either.
            if (std::abs(p.x() - std::round(p.x())) < 1e-3 ||
                std::abs(p.y() - std::round(p.y())) < 1e-3)
                continue;
            const Eigen::Vector2i at = p.array().floor().cast<int>();
            if (!carried.depth.view().contains(at.x(), at.y()))
                continue;
            REQUIRE(carried.depth(at.x(), at.y()) == Approx(X.z()).margin(6e-4));
            ++landed;
        }
    CHECK(landed > 150);
}

TEST_CASE("warping to a rolling shutter's view shows each row at the time when it is read",
          "[core]") {
    Twist motion;
    motion << 0.2, -0.1, 0.03, 0.03, -0.02, 0.05;
    const DepthMap map = scattered_points();
    const Carried carried(map, Pose::identity(), 1, one_by_one(), {.motion = motion});
    int seen = 0, landed = 0, elsewhere = 0;
    for (int v = 4; v < camera.height; v += 9)
        for (int u = 4; u < camera.width; u += 9) {
            const Eigen::Vector3d X = camera.back_project(u, v, 0.001 * map(u, v));
            const double part = (v - (camera.height - 1) / 2.0) / camera.height;
            const Eigen::Vector3d Y = X + part * (motion.head<3>() + motion.tail<3>().cross(X));
            const Eigen::Vector2d p = camera.project(Y) + Eigen::Vector2d::Constant(0.5);
            if (std::abs(p.x() - std::round(p.x())) < 1e-3 ||
                std::abs(p.y() - std::round(p.y())) < 1e-3)
                continue;
            const Eigen::Vector2i at = p.array().floor().cast<int>();
            if (!carried.depth.view().contains(at.x(), at.y()))
                continue;
            // Where rows are hardly displaced, tiles are mapped to half a pixel.
            REQUIRE(shown_at(carried, at.x(), at.y()) == Approx(Y.z()).margin(2e-3));
            ++seen;
            landed += carried.depth(at.x(), at.y()) != 0.0f;
            elsewhere += at != Eigen::Vector2i(u, v);
        }
    CHECK(seen > 150);
    CHECK(landed > 0.9 * seen);
    CHECK(elsewhere > 100);
}

TEST_CASE("warping lets a depth edge that is left out hide what is behind it", "[core]") {
    // Seen from 20 cm to the left the plate hides the wall at its right side: it goes 29.7 pixels
    // to the right and the wall half of that.
    const auto through_the_edge = [](bool edges_hide) {
        WarpOptions options;
        options.edges_hide = edges_hide;
        const Carried carried(wall_and_plate(), shifted(0.198, 0, 0), 1, options);
        int through = 0;
        for (int v = 32; v < 68; ++v) {
            CHECK(carried.depth(100, v) == Approx(1).margin(0.01)); // the plate itself
            CHECK(carried.depth(125, v) == Approx(2).margin(0.01)); // and the wall beside it
            // The plate fills the columns 80 to 119 of the view.
            for (int u = 81; u <= 119; ++u)
                through += carried.depth(u, v) > 1.5;
        }
        return through;
    };
    CHECK(through_the_edge(false) == 0); // its points are searched for
    CHECK(through_the_edge(true) == 0);
}

TEST_CASE("warping shows the nearest of the surfaces that land on a pixel", "[core]") {
    // The plate goes 15 pixels to the right, the wall half of that.
    const Carried carried(wall_and_plate(), shifted(0.1, 0, 0), 1, all_carried());
    for (int v = 32; v < 68; ++v)
        for (int u = 67; u < 103; ++u)
            REQUIRE(carried.depth(u, v) == Approx(1).margin(1e-3));
}

TEST_CASE("warping leaves disocclusions empty and does not widen silhouettes", "[core]") {
    // The plate goes twice as far to the right as the wall.
    const int by = GENERATE(8, 16, 30);
    const bool searched = GENERATE(false, true);
    CAPTURE(by, searched);
    const Carried carried(wall_and_plate(), shifted(by / camera.fx, 0, 0), 1,
                          searched ? all_carried() : one_by_one());
    int near = 0, uncovered = 0, wrong = 0;
    for (int v = 35; v < 65; ++v)
        for (int u = 0; u < camera.width; ++u) {
            const float z = carried.depth(u, v);
            near += z > 0.9f && z < 1.1f;
            uncovered += u >= 50 + by / 2 && u < 50 + by && z == 0.0f;
            wrong += z > 0.9f && z < 1.1f && (u < 50 + by || u >= 90 + by);
        }
    CHECK(near == 30 * 40);
    CHECK(wrong == 0);
    CHECK(uncovered >= 30 * (by / 2 - 1));
}

TEST_CASE("warping fills the cracks of a surface that is carried point by point", "[core]") {
    const Pose nearer = shifted(0, 0, -0.4); // 2 m to 1.6 m: one pixel in five is missed
    DepthMap pierced = wall(2000);           // so that its points are carried one by one
    for (int v = 3; v < camera.height; v += 12)
        for (int u = 3; u < camera.width; u += 12)
            pierced(u, v) = 500;
    const Carried left(pierced, nearer, 1, one_by_one(), {}, 0);
    const Carried filled(pierced, nearer, 1, one_by_one());
    CHECK(left.holes(10) > 2000);
    CHECK(filled.holes(10) < 0.1 * left.holes(10)); // those of the points in front of the wall
    for (const std::uint16_t mm : filled.millimetres.pixels())
        REQUIRE((mm == 0 || mm == 1600));
}

TEST_CASE("warping leaves no cracks in a smooth surface", "[core]") {
    const Carried carried(wall(2000), shifted(0, 0, -0.4), 1, {}, {}, 0);
    // Tiles at the border are not all of the surface.
    CHECK(carried.holes(TileMapping::tile_px) == 0);
    for (const std::uint16_t mm : carried.millimetres.pixels())
        REQUIRE((mm == 0 || mm == 1600));
}

TEST_CASE("warping shows a leaning plane at its place and depth", "[core]") {
    // A plane n . X = 1 that leans to two sides, seen from elsewhere.
    const Eigen::Vector3d n = Eigen::Vector3d(0.15, -0.1, 1) / 2.0;
    const Pose pose{rotation({0.03, -0.04, 0.2}), {0.06, -0.05, 0.1}};
    DepthMap map = wall(0);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            map(u, v) =
                static_cast<std::uint16_t>(1000 / n.dot(camera.back_project(u, v, 1)) + 0.5);
    const Eigen::Vector3d turned = pose.R * n;
    const Eigen::Vector3d there = turned / (1 + turned.dot(pose.T));
    for (const bool rolling : {false, true}) {
        RollingShutter shutter;
        if (rolling)
            shutter.motion << 0, 0, 0.02, 0, 0, 0; // the last row is 2 cm nearer than the first
        const Carried carried(map, pose, 1, {}, shutter);
        int compared = 0;
        double sum = 0;
        for (int v = 20; v < camera.height - 20; ++v)
            for (int u = 30; u < camera.width - 30; ++u) {
                if (carried.depth(u, v) == 0.0f)
                    continue;
                const double part = rolling ? (v - (camera.height - 1) / 2.0) / camera.height : 0;
                const Eigen::Vector3d moved = part * Eigen::Vector3d(0, 0, 0.02);
                const Eigen::Vector3d now = there / (1 + there.dot(moved));
                const double expected = 1 / now.dot(camera.back_project(u, v, 1));
                const double error = std::abs(carried.depth(u, v) - expected) / expected;
                CAPTURE(u, v, expected);
                REQUIRE(error < 0.003);
                sum += error;
                ++compared;
            }
        CHECK(compared > 4000);
        CHECK(sum / compared < 0.0006); // of 1 mm readings
    }
}

TEST_CASE("warping shows no far surface through the cracks of a near one", "[core]") {
    // The plate comes from 1 m to 0.7 m and is torn; the wall behind it lands in its cracks.
    const Carried carried(wall_and_plate(), shifted(0, 0, -0.3));
    for (int v = 35; v < 60; ++v)
        for (int u = 55; u < 90; ++u)
            REQUIRE(carried.depth(u, v) < 1.0f);
}

TEST_CASE("warping gives the same map for any number of workers", "[core]") {
    const Pose pose{rotation({0.02, 0.1, 0.05}), {0.1, -0.05, -0.2}};
    const Carried one(wall_and_plate(), pose);
    for (const int workers : {2, 3, 7}) {
        const Carried several(wall_and_plate(), pose, workers);
        CHECK(several.millimetres == one.millimetres);
        CHECK(several.edges == one.edges);
        CHECK(several.drawn == one.drawn);
    }
}

TEST_CASE("warping draws nothing from behind the camera, out of view or by an invalid pose",
          "[core]") {
    const double nan = std::nan("");
    for (const Pose &pose : {shifted(0, 0, -3), shifted(100, 0, 0), shifted(nan, 0, 0),
                             shifted(0, 0, 1e9), Pose{Eigen::Matrix3d::Constant(nan), {0, 0, 0}}}) {
        const Carried carried(wall(2000), pose);
        CHECK(carried.drawn == 0);
        for (const float z : carried.depth.pixels())
            REQUIRE(z == 0.0f);
        for (const std::uint8_t edge : carried.edges.pixels())
            REQUIRE(edge == 0);
    }
}

TEST_CASE("warping tells how far each pixel's point is from the next depth edge", "[core]") {
    const Carried carried(wall_and_plate(), shifted(0.02, 0, 0));
    int counted = 0;
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
            REQUIRE((carried.edges(u, v) == 0) == (carried.millimetres(u, v) == 0));
            counted += carried.millimetres(u, v) != 0;
        }
    CHECK(carried.drawn == counted);
    // The plate is seen from column 53 to 92; its own edge is not carried.
    CHECK(carried.edges(54, 50) == 2);
    CHECK(carried.edges(57, 50) == 5);
    CHECK(carried.edges(70, 50) == far_from_edge);
}

TEST_CASE("the bounds that warping tells of a tile hold for the readings of all its pixels",
          "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    DepthMap room = wall_and_plate();
    for (int v = 0; v < 40; ++v) // a slope that ends at a hole
        for (int u = 0; u < 40; ++u)
            room(u, v) = u < 30 ? static_cast<std::uint16_t>(2000 - 3 * u - 2 * v) : 0;
    int even = 0, empty = 0, unknown = 0;
    for (const bool edges_hide : {false, true})
        for (const double metres : {0.0, 0.03, -0.3, 0.9}) {
            const Carried carried(room, shifted(metres, metres / 2, 0), 2,
                                  {.least_edge_distance_px = 2, .edges_hide = edges_hide});
            REQUIRE(carried.tiles.width() == (camera.width + 15) / 16);
            REQUIRE(carried.tiles.height() == (camera.height + 15) / 16);
            for (int v = 0; v < camera.height; ++v)
                for (int u = 0; u < camera.width; ++u) {
                    const TileReadings &tile = carried.tiles(u / 16, v / 16);
                    CAPTURE(edges_hide, metres, u, v);
                    (!tile.known() ? unknown : tile.farthest == 0 ? empty : even) += 1;
                    if (!tile.known())
                        continue;
                    REQUIRE(carried.edges(u, v) == tile.edge_distance);
                    REQUIRE(carried.millimetres(u, v) >= tile.nearest);
                    REQUIRE(carried.millimetres(u, v) <= tile.farthest);
                }
        }
    CHECK(even > 10000);
    CHECK(empty > 10000);
    CHECK(unknown > 10000);
}

TEST_CASE("warping carries no reading nearer to a depth edge than asked for", "[core]") {
    WarpOptions options;
    options.least_edge_distance_px = GENERATE(1, 2, 4, 7);
    options.edges_hide = GENERATE(false, true);
    CAPTURE(options.least_edge_distance_px, options.edges_hide);
    int least = 255;
    // The plate begins at the last pixel of a piece, so that the next one is whole and near to the
    // edge; it moves on by half a pixel each time, so that it comes to lie anywhere on the tiles.
    const DepthMap map =
        wall_and_plate(6 * SurfacePieces::piece_px - 1, 7 * SurfacePieces::piece_px - 1);
    for (int k = 0; k <= 2 * TileMapping::tile_px; ++k) {
        const double by = 0.5 * k / camera.fx;
        const Carried carried(map, shifted(by, by, 0), 1, options);
        for (int v = 0; v < camera.height; ++v)
            for (int u = 0; u < camera.width; ++u)
                if (carried.edges(u, v) != 0)
                    least = std::min<int>(least, carried.edges(u, v));
        CHECK(carried.drawn > camera.width * camera.height / 2);
    }
    CHECK(least == options.least_edge_distance_px);
}
