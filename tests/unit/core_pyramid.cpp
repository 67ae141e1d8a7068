// SPDX-License-Identifier: Apache-2.0
#include "core/base/pyramid.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <random>

using namespace afterglow;

namespace {

/// Of the square of so many pixels that becomes pixel (u, v).
int sum_of_square(LumaView image, int size, int u, int v) {
    int sum = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            sum += image(size * u + x, size * v + y);
    return sum;
}

} // namespace

TEST_CASE("each pixel of an image pyramid is the exact mean of the pixels below it", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(1);
    std::uniform_int_distribution<int> grey(0, 255);
    // Widths with and without a rest of a vector, an odd one, and views into wider images.
    for (const int width : {16, 37, 64, 90, 131, 640})
        for (const bool extreme : {false, true}) {
            constexpr int height = 33, levels = 4;
            Luma image(width + 5, height);
            for (std::uint8_t &pixel : image.pixels())
                pixel =
                    static_cast<std::uint8_t>(extreme ? 255 * (grey(random) % 2) : grey(random));
            const LumaView view(image.row(0) + 2, width, height, image.width());
            Pyramid pyramid(width, height, levels);
            pyramid.build(view);
            for (int level = 1; level <= levels; ++level) {
                const GreyView halved = pyramid.level(level);
                const int size = 1 << level;
                REQUIRE(halved.width() == width >> level);
                REQUIRE(halved.height() == height >> level);
                for (int v = 0; v < halved.height(); ++v)
                    for (int u = 0; u < halved.width(); ++u) {
                        const int sum = sum_of_square(view, size, u, v);
                        CAPTURE(width, level, u, v);
                        REQUIRE(halved(u, v) == sum * (grey_steps / (size * size)));
                    }
            }
        }
}

TEST_CASE("pixels of coarse pyramid levels are rounded means", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    constexpr int levels = 6;
    Luma image(19 << levels, 2 << levels); // level 5 has whole vectors and a rest
    std::mt19937 random(2);
    for (std::uint8_t &pixel : image.pixels())
        pixel = static_cast<std::uint8_t>(random() % 256);
    Pyramid pyramid(image.width(), image.height(), levels);
    pyramid.build(image);
    const auto mean = [](int a, int b) { return (a + b + 1) / 2; };
    for (int level = 5; level <= levels; ++level) {
        const GreyView finer = pyramid.level(level - 1), coarse = pyramid.level(level);
        for (int v = 0; v < coarse.height(); ++v)
            for (int u = 0; u < coarse.width(); ++u) {
                CAPTURE(level, u, v);
                CHECK(coarse(u, v) ==
                      mean(mean(finer(2 * u, 2 * v), finer(2 * u, 2 * v + 1)),
                           mean(finer(2 * u + 1, 2 * v), finer(2 * u + 1, 2 * v + 1))));
                const double exact =
                    sum_of_square(image, 1 << level, u, v) / double(1 << 2 * level);
                CHECK(coarse(u, v) == Approx(grey_steps * exact).margin(2));
            }
    }
}

TEST_CASE("a white image is white on all levels of its pyramid", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    const Luma image(192, 128, 255);
    Pyramid pyramid(image.width(), image.height(), 6);
    pyramid.build(image);
    for (int level = 1; level <= pyramid.levels(); ++level)
        for (int v = 0; v < pyramid.level(level).height(); ++v)
            for (int u = 0; u < pyramid.level(level).width(); ++u)
                REQUIRE(pyramid.level(level)(u, v) == 255 * grey_steps);
}

TEST_CASE("workers that share a pyramid build the one that a single thread builds",
          "[core][tsan]") {
    const int levels = GENERATE(1, 4, 6);
    Luma image(333, 215);
    std::mt19937 random(3);
    for (std::uint8_t &pixel : image.pixels())
        pixel = static_cast<std::uint8_t>(random());
    Pyramid alone(image.width(), image.height(), levels), shared = alone;
    alone.build(image);
    WorkerPool pool(3);
    shared.build(image, pool);
    for (int level = 1; level <= levels; ++level)
        for (int v = 0; v < alone.level(level).height(); ++v)
            REQUIRE(std::equal(alone.level(level).row(v),
                               alone.level(level).row(v) + alone.level(level).width(),
                               shared.level(level).row(v)));
}
