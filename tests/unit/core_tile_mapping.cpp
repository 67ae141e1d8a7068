// SPDX-License-Identifier: Apache-2.0
#include "core/warp/tile_mapping.hpp"
#include "tests/catch.hpp"

#include <vector>

using namespace afterglow;

namespace {

const Intrinsics camera{300, 300, 159.5, 119.5, 320, 240};

DepthSurface surface_of(const DepthMap &map) {
    WorkerPool alone(1);
    SurfaceOptions as_measured;
    as_measured.smooth_radius_px = 0;
    DepthSurface surface(camera, as_measured);
    surface.build(map, alone);
    return surface;
}

/// How many tiles have each content.
struct Contents {
    int nothing = 0, mapped = 0, mixed = 0;
};
Contents contents(const DepthSurface &surface, const Pose &pose, bool search = true) {
    WorkerPool alone(1);
    TileMapping tiles(camera, camera, {2, search}, alone);
    tiles.find(surface, SurfaceProjection(camera, camera, pose, {}), {}, 1);
    Contents found;
    for (int y = 0; y < tiles.rows(); ++y)
        for (int x = 0; x < tiles.columns(); ++x) {
            found.nothing += tiles.content(x, y) == TileContent::nothing;
            found.mapped += tiles.content(x, y) == TileContent::mapped;
            found.mixed += tiles.content(x, y) == TileContent::mixed;
        }
    return found;
}

/// All coordinates of the corners of all mapped tiles.
std::vector<float> corners(const TileMapping &tiles) {
    std::vector<float> found;
    for (int y = 0; y < tiles.rows(); ++y)
        for (int x = 0; x < tiles.columns(); ++x)
            if (tiles.content(x, y) == TileContent::mapped) {
                const MappedTile &tile = tiles.mapped(x, y);
                for (const MappedCorner &corner : tile.corners)
                    found.insert(found.end(),
                                 {corner.u, corner.v, corner.z, corner.scale, corner.shift});
            }
    return found;
}

} // namespace

TEST_CASE("the tiles of a wall straight ahead are mapped alike whichever worker is first",
          "[core][tsan]") {
    WorkerPool alone(1);
    const DepthSurface surface = surface_of(DepthMap(camera.width, camera.height, 2000));
    const SurfaceProjection projection(camera, camera,
                                       {rotation({0.02, 0.1, 0.05}), {0.1, -0.05, -0.2}}, {});
    TileMapping one(camera, camera, {2, true}, alone);
    one.find(surface, projection, {}, 1);
    const std::vector<float> expected = corners(one);
    REQUIRE(expected.size() > 1000);
    for (const int workers : {2, 5}) {
        WorkerPool pool(workers);
        TileMapping several(camera, camera, {2, true}, pool);
        for (int i = 0; i < 200; ++i) {
            several.find(surface, projection, {}, 1);
            REQUIRE(corners(several) == expected);
        }
    }
}

TEST_CASE("tiles whose points hide nothing of each other, or may be searched for, are mapped",
          "[core]") {
    constexpr int all = 320 / TileMapping::tile_px * (240 / TileMapping::tile_px);
    const auto shifted = [](double x) { return Pose{Eigen::Matrix3d::Identity(), {x, 0, 0}}; };
    DepthMap wall(camera.width, camera.height, 2000);
    SECTION("a wall, also where it ends") {
        const Contents found = contents(surface_of(wall), shifted(0.2)); // by 30 pixels
        CHECK(found.mapped == 19 * 15);
        CHECK(found.nothing == 1 * 15);
    }
    SECTION("a wall with holes") {
        for (int v = 0; v < camera.height; ++v)
            for (int u = 0; u < camera.width; ++u)
                if (u % 40 < 10 && v % 30 < 10)
                    wall(u, v) = 0;
        CHECK(contents(surface_of(wall), shifted(0.2)).mapped == 19 * 15);
    }
    SECTION("a plate before a wall") {
        for (int v = 80; v < 160; ++v)
            for (int u = 100; u < 200; ++u)
                wall(u, v) = 1000;
        const DepthSurface surface = surface_of(wall);
        CHECK(contents(surface, shifted(0)).mapped == all);
        CHECK(contents(surface, shifted(0.006)).mapped == all);   // 0.9 pixels of parallax
        CHECK(contents(surface, shifted(0.1)).mixed == 0);        // 15 pixels
        CHECK(contents(surface, shifted(0.1)).mapped > all - 15); // where neither has ended
        const Contents unsearched = contents(surface, shifted(0.1), false);
        CHECK(unsearched.mixed > 20);
        CHECK(unsearched.mixed < 80);
        CHECK(unsearched.mapped > all - 100);
    }
    SECTION("two walls beside each other across a wide hole are not one surface") {
        for (int v = 0; v < camera.height; ++v)
            for (int u = 0; u < camera.width; ++u)
                wall(u, v) = u < 152 ? 2000 : u < 168 ? 0 : 2200;
        // Where both are seen the corners put one of them beside its place.
        const Contents found = contents(surface_of(wall), shifted(0.4), false);
        CHECK(found.mixed >= 8);
    }
}
