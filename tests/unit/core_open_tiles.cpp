// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/open_tiles.hpp"
#include "tests/catch.hpp"

#include <limits>
#include <random>

using namespace afterglow;

TEST_CASE("OpenTiles marks exactly the tiles with an empty pixel", "[core]") {
    constexpr int width = 70, height = 37, px = OpenTiles::tile_px;
    std::mt19937 random(3);
    DepthMap map(width, height, std::uint16_t{1});
    for (int i = 0; i < 5; ++i)
        map(static_cast<int>(random() % width), static_cast<int>(random() % height)) = 0;
    OpenTiles open(width, height);
    open.find(map);

    const auto tile_is_open = [&](int x, int y) {
        for (int v = y * px; v < std::min((y + 1) * px, height); ++v)
            for (int u = x * px; u < std::min((x + 1) * px, width); ++u)
                if (map(u, v) == 0)
                    return true;
        return false;
    };
    for (int v = 0; v < height; ++v) {
        std::vector<int> covered(width);
        open.for_each_run(v, [&](int begin, int end) {
            for (int u = begin; u < end; ++u)
                ++covered[static_cast<std::size_t>(u)];
        });
        for (int u = 0; u < width; ++u)
            REQUIRE(covered[static_cast<std::size_t>(u)] == tile_is_open(u / px, v / px));
    }
    for (int n = 0; n < 2000; ++n) {
        const int u0 = static_cast<int>(random() % 120) - 25;
        const int v0 = static_cast<int>(random() % 90) - 25;
        const int u1 = u0 + static_cast<int>(random() % 40);
        const int v1 = v0 + static_cast<int>(random() % 40);
        bool expected = false;
        for (int v = std::max(v0, 0); v <= std::min(v1, height - 1); ++v)
            for (int u = std::max(u0, 0); u <= std::min(u1, width - 1); ++u)
                expected |= tile_is_open(u / px, v / px);
        REQUIRE(open.any(static_cast<float>(u0), static_cast<float>(v0), static_cast<float>(u1),
                         static_cast<float>(v1)) == expected);
    }
}

TEST_CASE("OpenTiles finds no tile for NaN or infinite coordinates", "[core]") {
    OpenTiles open(32, 32);
    open.find(DepthMap(32, 32));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    CHECK_FALSE(open.any(nan, nan, nan, nan));
    CHECK_FALSE(open.any(inf, inf, inf, inf));
    CHECK(open.any(-inf, -inf, inf, inf));
}
