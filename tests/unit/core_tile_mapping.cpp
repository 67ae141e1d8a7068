// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/tile_mapping.hpp"
#include "tests/catch.hpp"

#include <vector>

using namespace afterglow;

namespace {

const Intrinsics camera{300, 300, 159.5, 119.5, 320, 240};

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
    SurfaceOptions as_measured;
    as_measured.smooth_radius_px = 0;
    DepthSurface surface(camera, as_measured);
    surface.build(DepthMap(camera.width, camera.height, 2000), alone);
    const SurfaceProjection projection(camera, camera,
                                       {rotation({0.02, 0.1, 0.05}), {0.1, -0.05, -0.2}}, {});
    TileMapping one(camera, camera, 2, alone);
    one.find(surface, projection, {}, 1);
    const std::vector<float> expected = corners(one);
    REQUIRE(expected.size() > 1000);
    for (const int workers : {2, 5}) {
        WorkerPool pool(workers);
        TileMapping several(camera, camera, 2, pool);
        for (int i = 0; i < 200; ++i) {
            several.find(surface, projection, {}, 1);
            REQUIRE(corners(several) == expected);
        }
    }
}
