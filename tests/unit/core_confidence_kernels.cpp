// SPDX-License-Identifier: Apache-2.0
// Kernels of confidences, and of maps that are compared, against the scalar code that they stand
// for.
#include "core/error/confidence_kernels.hpp"
#include "core/error/map_comparison.hpp"
#include "core/estimate.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace afterglow;

namespace {

/// A map of surfaces that are `spread` millimetres deep, with holes.
Image<std::uint16_t> some_depths(std::mt19937 &random, int width, int height, unsigned spread) {
    Image<std::uint16_t> depth(width, height);
    std::uint16_t base = 0;
    for (std::uint16_t &mm : depth.pixels()) {
        if (random() % 50 == 0)
            base = static_cast<std::uint16_t>(1 + random() % 16000);
        mm = random() % 9 == 0 ? 0 : static_cast<std::uint16_t>(base + random() % spread);
    }
    return depth;
}

/// Four bins to an octave; below it one for each millimetre.
int bin_of(std::uint16_t mm) {
    if (mm < 4)
        return mm;
    int octave = 0;
    const double part = std::frexp(mm, &octave); // in 0.5 .. 1
    return 4 * (octave - 2) + static_cast<int>(4 * (2 * part - 1));
}

} // namespace

TEST_CASE("the depth bins of confidences are at most a quarter of their depth wide") {
    for (int mm = 1; mm <= 0xffff; ++mm) {
        const int bin = depth_bin(static_cast<std::uint16_t>(mm));
        CAPTURE(mm, bin);
        REQUIRE(bin == bin_of(static_cast<std::uint16_t>(mm)));
        REQUIRE(first_of_bin(bin) <= mm);
        REQUIRE(mm < first_of_bin(bin + 1));
        REQUIRE(first_of_bin(bin + 1) - first_of_bin(bin) <= std::max(1, mm / 4));
        REQUIRE(std::abs(middle_of_bin(bin) - 0.001f * static_cast<float>(mm)) <=
                std::max(0.001f, 0.000126f * static_cast<float>(mm)));
    }
}

TEST_CASE("confidences are looked up alike in vectors, by tiles and one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(1);
    constexpr int layers = 3;
    std::vector<std::uint8_t> table(layers * class_layer * depth_bins);
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = i % class_layer == 0 ? 0 : static_cast<std::uint8_t>(1 + random() % 250);
    std::vector<std::uint8_t> other_table = table;
    for (std::uint8_t &confidence : other_table)
        confidence = confidence / 2;
    for (int round = 0; round < 300; ++round) {
        const int width = 1 + static_cast<int>(random() % 60);
        const int height = 1 + static_cast<int>(random() % 9);
        const unsigned spread = round % 3 == 0 ? 30 : round % 3 == 1 ? 150 : 5000;
        auto depth = some_depths(random, width, height, spread);
        if (round % 10 == 0)
            depth.pixels().back() = 0xffff;
        if (round % 10 == 1) // nothing in the first runs
            std::fill_n(depth.pixels().begin(), std::min(width, 40), std::uint16_t{0});
        Image<std::uint8_t> classes(width, height), confidence(width, height, 99);
        const unsigned most_layers = round % 2 == 0 ? 1 : layers;
        const auto some_class = [&] {
            return static_cast<std::uint8_t>(random() % most_layers * class_layer + 1 +
                                             random() % (class_layer - 1));
        };
        for (std::size_t i = 0; i < depth.pixels().size(); ++i)
            if (depth.pixels()[i] != 0)
                classes.pixels()[i] = some_class();
        const int summed_row = 1 + static_cast<int>(random() % 3);
        const int tile_rows = summed_row * (1 + static_cast<int>(random() % 3));
        Image<std::uint16_t> places((width + judged_tile_px - 1) / judged_tile_px,
                                    (height + tile_rows - 1) / tile_rows, places_differ);
        for (int y = 0; y < places.height(); ++y)
            for (int x = 0; x < places.width(); ++x) {
                if (random() % 3 == 0)
                    continue;
                const bool empty = random() % 3 == 0;
                const int bin = empty ? 0 : 20 + static_cast<int>(random() % 30);
                const std::uint8_t of = empty ? std::uint8_t{0} : some_class();
                places(x, y) = static_cast<std::uint16_t>(place_in_table(of, bin));
                const auto wide = static_cast<unsigned>(first_of_bin(bin + 1) - first_of_bin(bin));
                for (int v = y * tile_rows; v < std::min((y + 1) * tile_rows, height); ++v)
                    for (int u = x * judged_tile_px; u < std::min((x + 1) * judged_tile_px, width);
                         ++u) {
                        classes(u, v) = of;
                        depth(u, v) =
                            static_cast<std::uint16_t>(first_of_bin(bin) + random() % wide);
                    }
            }
        const auto less = static_cast<std::uint8_t>(round % 4 > 1 ? random() % 255 : 0);
        const int first_bin = depth_bin(depth.pixels()[depth.pixels().size() / 2]);
        const bool by_tiles = round % 5 != 0;
        const ConfidenceSums sums = look_up_confidences(
            {depth, classes, by_tiles ? places.view() : ImageView<std::uint16_t>(), tile_rows},
            {table.data(), other_table.data(), less}, first_bin, summed_row, confidence);
        ConfidenceSums expected_sums;
        for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
            const std::uint16_t mm = depth.pixels()[i];
            const auto place =
                static_cast<std::size_t>(place_in_table(classes.pixels()[i], bin_of(mm)));
            const auto lowered = [&](int in_table) {
                const int least = std::min<int>(in_table, unknown_confidence);
                return mm == 0 ? no_confidence : std::max(in_table - less, least);
            };
            const int expected = lowered(table[place]), other = lowered(other_table[place]);
            CAPTURE(round, i, mm, place, less);
            REQUIRE(confidence.pixels()[i] == expected);
            if (static_cast<int>(i) / width % summed_row == 0) {
                expected_sums.by_table += {static_cast<std::uint64_t>(expected), expected != 0};
                expected_sums.by_other_table += {static_cast<std::uint64_t>(other), other != 0};
            }
        }
        REQUIRE(sums.by_table == expected_sums.by_table);
        REQUIRE(sums.by_other_table == expected_sums.by_other_table);
    }
}

TEST_CASE("a map's errors are compared alike in vectors and one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(4);
    for (int round = 0; round < 200; ++round) {
        const int width = 1 + static_cast<int>(random() % 40);
        const int height = 1 + static_cast<int>(random() % 5);
        const auto composed = some_depths(random, width, height, 900);
        const auto measured = some_depths(random, width, height, 900);
        Image<std::uint8_t> confidence(width, height);
        for (std::uint8_t &of_pixel : confidence.pixels())
            of_pixel = static_cast<std::uint8_t>(random() % 256);
        const float misplaced = round % 2 == 0 ? 0.0f : 0.02f;
        double true_sum = 0, expected_sum = 0;
        int pixels = 0;
        for (int v = 0; v < height; v += 2)
            for (int u = 0; u < width; u += 2) {
                const double truth = measured(u, v), shown = composed(u, v);
                if (truth == 0 || shown == 0)
                    continue;
                true_sum += std::abs(shown - truth) / truth;
                expected_sum +=
                    std::max(expected_error(confidence(u, v)) - misplaced, confidence_step);
                ++pixels;
            }
        const ComparedErrors found = compare_errors({composed, confidence, measured}, misplaced);
        CAPTURE(round, width, height);
        REQUIRE(found.pixels == pixels);
        REQUIRE(found.true_sum == Approx(true_sum).epsilon(1e-5).margin(1e-6));
        REQUIRE(found.expected_sum == Approx(expected_sum).epsilon(1e-5).margin(1e-6));
    }
}

TEST_CASE("a measured row replaces what it has and leaves the rest", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        const int count = 1 + static_cast<int>(random() % 70);
        const auto measured = some_depths(random, count, 1, 900);
        auto depth = some_depths(random, count, 1, 900);
        Image<std::uint8_t> confidence(count, 1);
        for (int u = 0; u < count; ++u)
            confidence(u, 0) =
                depth(u, 0) == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(1 + random() % 255);
        const auto old_depth = depth;
        const auto old_confidence = confidence;
        const Overlaid found = lay_over(measured.row(0), count, depth.row(0), confidence.row(0));
        int there_in_all = 0;
        ConfidenceSum covered;
        for (int u = 0; u < count; ++u) {
            const bool there = measured(u, 0) != 0;
            there_in_all += there;
            CAPTURE(round, u);
            REQUIRE(depth(u, 0) == (there ? measured(u, 0) : old_depth(u, 0)));
            REQUIRE(confidence(u, 0) == (there ? measured_confidence : old_confidence(u, 0)));
            covered += {confidence(u, 0), depth(u, 0) != 0};
        }
        REQUIRE(found.measured == there_in_all);
        REQUIRE(found.covered == covered);
    }
}
