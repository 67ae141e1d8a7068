// SPDX-License-Identifier: Apache-2.0
#include "core/paper/three_step_search.hpp"
#include "tests/catch.hpp"

#include <cmath>

using namespace afterglow;

namespace {

/// A smooth bump at (u, v): its differences fall steadily towards the right displacement, so that
/// a coarse search cannot be led astray.
Luma bump(double u, double v) {
    Luma image(128, 96);
    for (int row = 0; row < image.height(); ++row)
        for (int column = 0; column < image.width(); ++column)
            image(column, row) = static_cast<std::uint8_t>(std::lround(
                200 * std::exp(-(std::pow(column - u, 2) + std::pow(row - v, 2)) / 400)));
    return image;
}

} // namespace

TEST_CASE("the three-step search finds every displacement within its reach", "[core]") {
    const Luma from = bump(64, 48);
    for (const auto &[du, dv] : {std::pair{0, 0}, {1, 0}, {-3, 2}, {8, -8}, {15, 0}, {-15, 15}})
        CHECK(three_step_search(from, bump(64 + du, 48 + dv), 64, 48, 15, 8) ==
              Displacement{du, dv});
}

TEST_CASE("the three-step search reaches no further than 15 pixels with step 8", "[core]") {
    const Displacement flow = three_step_search(bump(64, 48), bump(94, 48), 64, 48, 15, 8);
    CHECK(flow.du == 15);
    CHECK(flow.dv == 0);
}

TEST_CASE("without texture the three-step search reports no motion", "[core]") {
    const Luma flat(64, 64, 77);
    CHECK(three_step_search(flat, flat, 32, 32, 15, 8) == Displacement{});
}

TEST_CASE("the three-step search never looks outside the image", "[core]") {
    const Luma image = bump(10, 8);
    const Displacement flow = three_step_search(image, bump(2, 2), 7, 7, 15, 8);
    CHECK(flow.du >= 0);
    CHECK(flow.dv >= 0);
}
