// SPDX-License-Identifier: Apache-2.0
#include "core/base/image.hpp"
#include "eval/datasets/alteration.hpp"
#include "tests/catch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <ranges>
#include <set>
#include <string>
#include <string_view>

using namespace afterglow;

namespace {

constexpr int width = 240, height = 192;

/// An image of a chessboard, and a ramp of depths from 1 m on, of which the first row has none.
struct Frame {
    Luma luma{width, height};
    DepthMap depth{width, height};

    Frame() {
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) {
                luma(u, v) = (u / 8 + v / 8) % 2 == 0 ? 80 : 180;
                depth(u, v) = static_cast<std::uint16_t>(v == 0 ? 0 : 1000 + 10 * v + u);
            }
    }
    bool operator==(const Frame &) const = default;
};

Frame altered(std::string_view name, std::uint64_t frame, Frame from = {}) {
    const Alteration *const alteration = find_alteration(name);
    REQUIRE(alteration);
    REQUIRE(alteration->change);
    alteration->change(frame, from.luma, from.depth);
    return from;
}

/// Mean and standard deviation of by how much the pixels of two images differ.
struct Difference {
    double mean = 0, deviation = 0;
};
template <class T, class Scale>
Difference difference(const Image<T> &now, const Image<T> &before, const Scale &scale) {
    double sum = 0, squares = 0;
    int count = 0;
    for (int v = 1; v < now.height(); ++v)
        for (int u = 0; u < now.width(); ++u, ++count) {
            const double d = (double{1} * now(u, v) - before(u, v)) / scale(before(u, v));
            sum += d;
            squares += d * d;
        }
    const double mean = sum / count;
    return {mean, std::sqrt(squares / count - mean * mean)};
}

} // namespace

TEST_CASE(
    "an alteration changes images or depth maps, not both, and the same frame in the same way") {
    const Frame original;
    std::set<std::string_view> of_depth;
    for (const Alteration &alteration : alterations()) {
        CAPTURE(alteration.name);
        CHECK(!alteration.shows.empty());
        if (!alteration.change)
            continue;
        const Frame first = altered(alteration.name, 1);
        CHECK(first == altered(alteration.name, 1));
        const bool image = first.luma != original.luma, depth = first.depth != original.depth;
        CHECK(image != depth);
        if (depth)
            of_depth.insert(alteration.name);
        // There is depth nowhere where there was none.
        CHECK(std::ranges::count(std::span(first.depth.row(0), width), 0) == width);
    }
    CHECK(of_depth ==
          std::set<std::string_view>{"coarse", "noisy", "patchy", "shifted", "short-range"});
    CHECK(find_alteration("noise") == nullptr);
}

TEST_CASE("every alteration is documented") {
    std::ifstream file(AFTERGLOW_SOURCE_DIR "/docs/evaluation.md");
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (const Alteration &alteration : alterations())
        CHECK(text.find(fmt::format("\n| `{}` | {} |\n", alteration.name, alteration.shows)) !=
              std::string::npos);
}

TEST_CASE("the noise of an altered recording has the documented deviation and differs by frame") {
    const Frame original;
    const auto itself = [](double z) { return z; };
    const auto one = [](double) { return 1.0; };
    const Difference depth = difference(altered("noisy", 3).depth, original.depth, itself);
    CHECK(depth.mean == Approx(0).margin(0.0005));
    CHECK(depth.deviation == Approx(0.012).epsilon(0.05));
    const Difference grey = difference(altered("grainy", 3).luma, original.luma, one);
    CHECK(grey.mean == Approx(0).margin(0.2));
    CHECK(grey.deviation == Approx(8).epsilon(0.05));
    for (const char *name : {"noisy", "grainy", "dim", "patchy", "flickering"})
        CHECK(altered(name, 3) != altered(name, 4));
}

TEST_CASE("an altered TOF camera is coarse, near-sighted, patchy or shifted") {
    Frame far;
    std::ranges::fill(far.depth.pixels(), std::uint16_t{2500});
    far.depth(7, 9) = 2501;
    const Frame seen = altered("short-range", 0, far);
    CHECK(seen.depth(7, 9) == 0);
    CHECK(std::ranges::count(seen.depth.pixels(), 2500) == width * height - 1);

    far.depth(7, 9) = 4000; // there steps are 96 mm
    far.depth(8, 9) = 4030;
    far.depth(9, 9) = 4100;
    const Frame coarse = altered("coarse", 0, far);
    CHECK(coarse.depth(7, 9) == 4032);
    CHECK(std::abs(coarse.depth(8, 9) - 4030) <= 49);
    CHECK(std::abs(coarse.depth(9, 9) - 4100) <= 51);

    const Frame original, shifted = altered("shifted", 0);
    CHECK(shifted.depth(4, 3) == original.depth(0, 1));
    CHECK(shifted.depth(width - 1, height - 1) == original.depth(width - 5, height - 3));
    CHECK(shifted.depth(3, 50) == 0);

    double holes = 0;
    constexpr int frames = 20;
    for (int i = 0; i < frames; ++i) {
        const Frame patchy = altered("patchy", static_cast<std::uint64_t>(i));
        holes += static_cast<double>(std::ranges::count(patchy.depth.pixels(), 0) - width);
        // Whole cells are missing.
        CHECK((patchy.depth(24, 24) == 0) == (patchy.depth(47, 47) == 0));
    }
    CHECK(holes / (frames * width * (height - 1)) == Approx(0.25).margin(0.03));
}

TEST_CASE("altered images are blurred, dim or flicker") {
    Frame point;
    std::ranges::fill(point.luma.pixels(), std::uint8_t{0});
    for (int v = 80; v < 84; ++v)
        for (int u = 100; u < 104; ++u)
            point.luma(u, v) = 255;
    const Frame blurred = altered("blurred", 0, point);
    double sum = 0, squares = 0;
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            sum += blurred.luma(u, v);
            squares += blurred.luma(u, v) * std::pow(u - 101.5, 2);
        }
    CHECK(sum == Approx(16 * 255).epsilon(0.1));
    // Of the square itself (1.25 pixels^2) and of three means over 5 pixels (2 each).
    CHECK(squares / sum == Approx(1.25 + 3 * 2).epsilon(0.1));

    const auto one = [](double) { return 1.0; };
    const auto itself = [](double grey) { return grey; };
    const Frame original;
    CHECK(difference(altered("dim", 5).luma, original.luma, itself).mean ==
          Approx(-0.7).margin(0.01));
    for (const auto &[frame, change] : {std::pair{0U, 0.0}, {1U, 0.104}, {2U, -0.104}, {3U, 0.0}})
        CHECK(difference(altered("flickering", frame).luma, original.luma, itself).mean ==
              Approx(change).margin(0.005));
    CHECK(difference(altered("flickering", 3).luma, original.luma, one).deviation == 0);
}

TEST_CASE("the alteration \"late\" gives each image the depth map of the image before") {
    const Alteration *const late = find_alteration("late");
    REQUIRE(late);
    FrameAlterer alterer(*late);
    for (std::uint16_t i = 0; i < 3; ++i) {
        Frame frame;
        const Luma luma = frame.luma;
        std::ranges::fill(frame.depth.pixels(), std::uint16_t(1000 + i));
        CHECK(alterer.alter(frame.luma, frame.depth) == (i > 0));
        CHECK(frame.luma == luma);
        if (i > 0)
            CHECK(std::ranges::count(frame.depth.pixels(), 999 + i) == width * height);
    }
}
