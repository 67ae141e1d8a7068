// SPDX-License-Identifier: Apache-2.0
#include "core/paper/grid_flow.hpp"
#include "eval/baselines/table_1.hpp"
#include "tests/catch.hpp"

#include <cmath>

using namespace afterglow;

namespace {

/// Waves in both directions, moved `shift` pixels to the right.
Luma waves(double shift) {
    Luma image(320, 240);
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            image(u, v) = static_cast<std::uint8_t>(128 + 60 * std::sin(0.11 * (u - shift)) +
                                                    60 * std::sin(0.13 * v));
    return image;
}

} // namespace

TEST_CASE("Lucas-Kanade measures flow with sub-pixel precision", "[baselines]") {
    std::vector<Match> matches;
    place_grid({}, DepthMap(320, 240, 2000), matches);
    REQUIRE(matches.size() == 144);
    find_lucas_kanade_flow({}, waves(0), waves(3.4), matches);
    CHECK(matches.size() > 120);
    for (const Match &match : matches) {
        CHECK(match.to.x() - match.from.x() == Approx(3.4).margin(0.1));
        CHECK(match.to.y() - match.from.y() == Approx(0).margin(0.1));
        CHECK(match.z == 2);
    }
}

TEST_CASE("points lost by Lucas-Kanade give no matches", "[baselines]") {
    std::vector<Match> matches;
    find_lucas_kanade_flow({}, waves(0), waves(0), matches);
    CHECK(matches.empty());
    place_grid({}, DepthMap(320, 240, 2000), matches);
    const Luma blank(320, 240, 100);
    find_lucas_kanade_flow({}, blank, blank, matches);
    CHECK(matches.empty());
}

TEST_CASE("the Harris detector finds the corners of squares", "[baselines]") {
    Luma image(320, 240, 50);
    for (int v = 60; v < 120; ++v)
        for (int u = 80; u < 200; ++u)
            image(u, v) = 200;
    const auto corners = find_harris_corners(image, 144);
    CHECK(corners.size() == 4);
    for (const Eigen::Vector2f &corner : corners) {
        CHECK(std::min(std::abs(corner.x() - 80), std::abs(corner.x() - 199)) <= 2);
        CHECK(std::min(std::abs(corner.y() - 60), std::abs(corner.y() - 119)) <= 2);
    }
    CHECK(find_harris_corners(Luma(320, 240, 9), 144).empty());
}
