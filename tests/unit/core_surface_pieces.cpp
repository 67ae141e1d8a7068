// SPDX-License-Identifier: Apache-2.0
#include "core/surface/surface_pieces.hpp"
#include "core/surface/surface_point.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <algorithm>
#include <cstdlib>
#include <random>

using namespace afterglow;

TEST_CASE(
    "each piece of a surface tells its depths, its least edge distance and whether it has holes",
    "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    // No multiples of a piece.
    constexpr int width = 43, height = 29, px = SurfacePieces::piece_px;
    std::mt19937 random(1);
    Image<float> z(width, height);
    for (const int one_in : {1, 2, 50, 1000}) {
        for (float &at : z.pixels())
            at = random() % one_in == 0
                     ? 0.0f
                     : with_edge_distance(0.001f * static_cast<float>(500 + random() % 9000),
                                          static_cast<std::uint8_t>(1 + random() % 7));
        for (int v = 5; v < 24; ++v) // some pieces have no depth at all
            for (int u = 10; u < 30; ++u)
                z(u, v) = 0;
        SurfacePieces pieces(width, height);
        pieces.find(z);
        for (int y = 0; y < pieces.nearest().height(); ++y)
            for (int x = 0; x < pieces.nearest().width(); ++x) {
                float nearest = 0, farthest = 0;
                int least = 0;
                bool holes = false;
                for (int v = y * px; v < std::min((y + 1) * px, height); ++v)
                    for (int u = x * px; u < std::min((x + 1) * px, width); ++u) {
                        if (z(u, v) == 0.0f) {
                            holes = true;
                            continue;
                        }
                        const int edge = edge_distance_of(z(u, v));
                        least = least == 0 ? edge : std::min(least, edge);
                        nearest = nearest == 0.0f ? z(u, v) : std::min(nearest, z(u, v));
                        farthest = std::max(farthest, z(u, v));
                    }
                for (const auto &[du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
                    if (const auto depth = pieces.farthest();
                        depth.contains(x + du, y + dv) && depth(x + du, y + dv) == 0.0f)
                        holes = true;
                CAPTURE(one_in, x, y);
                REQUIRE(pieces.nearest()(x, y) == nearest);
                REQUIRE(pieces.farthest()(x, y) == farthest);
                if (farthest == 0.0f)
                    continue;
                const SurfacePart &part = pieces.parts()(x, y);
                REQUIRE(part.nearest() == nearest);
                REQUIRE(part.farthest() == farthest);
                REQUIRE(part.least_edge_distance() == least);
                REQUIRE(part.holes() == holes);
            }
    }
}

TEST_CASE("the nearest piece with depth around a pixel is found within three pieces", "[core]") {
    constexpr int px = SurfacePieces::piece_px, across = 11;
    const auto centre = [](int piece) { return piece * px + px / 2; };
    for (int y = 0; y < across; ++y)
        for (int x = 0; x < across; ++x) {
            Image<float> z(across * px, across * px);
            z(centre(x), centre(y)) = with_edge_distance(2.0f, 3);
            z(0, 0) = with_edge_distance(1.0f, 3); // nearer to the camera, but farther from (5, 5)
            SurfacePieces pieces(z.width(), z.height());
            pieces.find(z);
            const int ring = std::max(std::abs(x - 5), std::abs(y - 5));
            CAPTURE(x, y);
            CHECK(pieces.nearest_around(centre(5), centre(5)) ==
                  (ring <= 3 ? z(centre(x), centre(y)) : 0.0f));
        }
}
