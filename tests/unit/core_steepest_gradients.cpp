// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/steepest_gradients.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <cstddef>
#include <random>
#include <vector>

using namespace afterglow;

TEST_CASE("the steepest gradient of each image column is found as pixel by pixel", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(9);
    const int width = GENERATE(3, 4, 7, 10, 17, 40, 67);
    const int height = GENERATE(3, 9, 12);
    CAPTURE(width, height);
    // Few grey values: gradients are often equal, and often zero.
    std::uniform_int_distribution<int> grey(0, 3);
    Image<float> image(width, height);
    for (float &pixel : image.pixels())
        pixel = 20.0f * static_cast<float>(grey(random));
    for (int first = 1; first < height - 1; ++first)
        for (int end = first + 1; end < height; ++end) {
            std::vector<float> steepness(static_cast<std::size_t>(width), -1.0f);
            std::vector<int> rows(static_cast<std::size_t>(width), -1);
            find_steepest(image, first, end, steepness, rows);
            CHECK(steepness.front() == -1);
            CHECK(steepness.back() == -1);
            for (int u = 1; u < width - 1; ++u) {
                float most = -1;
                int at = -1;
                for (int v = first; v < end; ++v) {
                    const float gx = 0.5f * (image(u + 1, v) - image(u - 1, v));
                    const float gy = 0.5f * (image(u, v + 1) - image(u, v - 1));
                    if (gx * gx + gy * gy > most) {
                        most = gx * gx + gy * gy;
                        at = v;
                    }
                }
                CAPTURE(first, end, u);
                REQUIRE(steepness[static_cast<std::size_t>(u)] == most);
                REQUIRE(rows[static_cast<std::size_t>(u)] == at);
            }
        }
}
