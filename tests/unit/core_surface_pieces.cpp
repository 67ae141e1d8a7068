// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_pieces.hpp"
#include "tests/catch.hpp"

#include <algorithm>
#include <random>

using namespace afterglow;

TEST_CASE(
    "each piece of a surface tells its depths, its least edge distance and whether it has holes",
    "[core]") {
    // No multiples of a piece.
    constexpr int width = 43, height = 29, px = SurfacePieces::piece_px;
    std::mt19937 random(1);
    Image<float> z(width, height);
    Image<std::uint8_t> edge(width, height);
    for (const int one_in : {1, 2, 50, 1000}) {
        for (std::size_t i = 0; i < z.pixels().size(); ++i) {
            z.pixels()[i] =
                random() % one_in == 0 ? 0.0f : 0.001f * static_cast<float>(500 + random() % 9000);
            edge.pixels()[i] = static_cast<std::uint8_t>(1 + random() % 7);
        }
        SurfacePieces pieces(width, height);
        pieces.find(z, edge);
        for (int y = 0; y < pieces.nearest().height(); ++y)
            for (int x = 0; x < pieces.nearest().width(); ++x) {
                float nearest = 0, farthest = 0;
                int least = 255;
                bool whole = true;
                for (int v = y * px; v < std::min((y + 1) * px, height); ++v)
                    for (int u = x * px; u < std::min((x + 1) * px, width); ++u) {
                        least = std::min<int>(least, edge(u, v));
                        whole = whole && z(u, v) != 0.0f;
                        if (z(u, v) == 0.0f)
                            continue;
                        nearest = nearest == 0.0f ? z(u, v) : std::min(nearest, z(u, v));
                        farthest = std::max(farthest, z(u, v));
                    }
                CAPTURE(one_in, x, y);
                REQUIRE(pieces.nearest()(x, y) == nearest);
                REQUIRE(pieces.farthest()(x, y) == farthest);
                REQUIRE(pieces.edge_distance()(x, y) == (whole ? least : 0));
            }
    }
}
