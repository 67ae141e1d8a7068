// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tools/picture/depth_scale.hpp"

using namespace afterglow;

namespace {

/// Pixels of the labels' colour right of the bar.
int ink_pixels(const Image<Rgb> &scale) {
    int count = 0;
    for (const Rgb &pixel : scale.pixels())
        count += pixel == Rgb{0, 0, 0};
    return count;
}

} // namespace

TEST_CASE("a depth scale runs from the colour of the nearest depth to that of the farthest") {
    const DepthRange range = {800, 3000};
    const Image<Rgb> scale = depth_scale(range, 240);
    CHECK(scale.height() == 240);
    CHECK(scale(0, 0) == depth_color(800, range.near_mm, range.far_mm));
    CHECK(scale(0, 239) == depth_color(3000, range.near_mm, range.far_mm));
    CHECK(ink_pixels(scale) > 100);
    // Other depths have other labels; a map without depth has none.
    CHECK(depth_scale({800, 4000}, 240).pixels().size() == scale.pixels().size());
    CHECK(ink_pixels(depth_scale({111, 111.1}, 240)) != ink_pixels(scale));
    CHECK(ink_pixels(depth_scale(depth_range(DepthMap(4, 4)), 240)) == 0);
}
