// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tools/picture/depth_colors.hpp"
#include "tools/picture/error_colors.hpp"
#include "tools/picture/text.hpp"

using namespace afterglow;

namespace {

bool same(const Rgb &a, const Rgb &b) {
    return a.red == b.red && a.green == b.green && a.blue == b.blue;
}

int brightness(const Rgb &color) {
    return color.red + color.green + color.blue;
}

} // namespace

TEST_CASE("a colour scale is interpolated between its stops and clamped at its ends", "[picture]") {
    const Rgb stops[] = {{0, 0, 0}, {100, 0, 50}, {200, 200, 50}};
    CHECK(same(interpolate(stops, 0), {0, 0, 0}));
    CHECK(same(interpolate(stops, 0.25), {50, 0, 25}));
    CHECK(same(interpolate(stops, 0.5), {100, 0, 50}));
    CHECK(same(interpolate(stops, 1), {200, 200, 50}));
    CHECK(same(interpolate(stops, 7), {200, 200, 50}));
    CHECK(same(interpolate(stops, -7), {0, 0, 0}));
}

TEST_CASE("near depth is red, far depth is violet, no depth is almost black", "[picture]") {
    const Rgb near = depth_color(500, 500, 4000);
    const Rgb far = depth_color(4000, 500, 4000);
    CHECK(near.red > 2 * near.blue);
    CHECK(far.blue > 2 * far.green);
    CHECK(same(depth_color(65535, 500, 4000), far));
    CHECK(same(depth_color(1, 500, 4000), near));
    CHECK(brightness(depth_color(0, 500, 4000)) < 64);
}

TEST_CASE("the depth range leaves out two percent at each end, and holes", "[picture]") {
    DepthMap depth(10, 20, 0);
    for (int v = 0; v < 10; ++v)
        for (int u = 0; u < 10; ++u)
            depth(u, v) = static_cast<std::uint16_t>(1000 + 10 * (10 * v + u));
    const DepthRange range = depth_range(depth);
    CHECK(range.near_mm == 1020);
    CHECK(range.far_mm == 1980);
    CHECK(depth_range(DepthMap(4, 4, 0)).near_mm == 0);
}

TEST_CASE("a depth map in colours has its size and each pixel's colour", "[picture]") {
    DepthMap depth(3, 2, 0);
    depth(2, 1) = 1500;
    const Image<Rgb> picture = color_depth(depth, {1000, 2000});
    CHECK(picture.width() == 3);
    CHECK(picture.height() == 2);
    CHECK(same(picture(2, 1), color_scale(0.5)));
    CHECK(same(picture(1, 1), depth_color(0, 1000, 2000)));
}

TEST_CASE("an error picture is the brighter the larger the relative error", "[picture]") {
    DepthMap truth(4, 1, 1000), estimate(4, 1, 1000);
    estimate(1, 0) = 1025; // 2.5 %
    estimate(2, 0) = 900;  // more than the largest shown
    estimate(3, 0) = 0;
    const Image<Rgb> picture = color_error(estimate, truth);
    CHECK(same(picture(0, 0), error_color(0)));
    CHECK(same(picture(1, 0), error_color(2.5)));
    CHECK(same(picture(2, 0), error_color(largest_error_shown)));
    CHECK(brightness(picture(0, 0)) < brightness(picture(1, 0)));
    CHECK(brightness(picture(1, 0)) < brightness(picture(2, 0)));
    CHECK(brightness(picture(3, 0)) < brightness(picture(0, 0)));
}

TEST_CASE("text is drawn in its colour, scaled, and cut at the picture's edge", "[picture]") {
    const Rgb ink{200, 100, 50};
    const auto inked = [&](const Image<Rgb> &picture) {
        int count = 0;
        for (int v = 0; v < picture.height(); ++v)
            for (int u = 0; u < picture.width(); ++u)
                count += same(picture(u, v), ink) ? 1 : 0;
        return count;
    };
    Image<Rgb> once(20, 10), twice(40, 20), edge(3, 3), blank(20, 10);
    draw_text(once.view(), 0, 0, "1", ink, 1);
    draw_text(twice.view(), 0, 0, "1", ink, 2);
    draw_text(edge.view(), -2, 0, "1", ink, 1);
    draw_text(blank.view(), 0, 0, "\x01", ink, 1);
    CHECK(inked(once) == 10); // 1 + 2 + 4 * 1 + 3, as the glyph is drawn
    CHECK(inked(twice) == 4 * inked(once));
    CHECK(inked(edge) > 0);
    CHECK(inked(edge) < inked(once));
    CHECK(inked(blank) == 0);
}
