// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/alteration.hpp"

#include "drivers/simulated/synthetic/random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace afterglow {
namespace {

using LumaPixels = ImageView<std::uint8_t>;
using DepthPixels = ImageView<std::uint16_t>;

/// Rounded, and limited to what T holds.
template <class T>
T rounded(double value) {
    return static_cast<T>(std::clamp(std::floor(value + 0.5), 0.0,
                                     static_cast<double>(std::numeric_limits<T>::max())));
}

/// value(pixel, u, v) is what a pixel becomes.
template <class T, class Value>
void change_each(ImageView<T> image, const Value &value) {
    for (int v = 0; v < image.height(); ++v)
        for (int u = 0; u < image.width(); ++u)
            image(u, v) = rounded<T>(value(image(u, v), u, v));
}

void add_noise(std::uint64_t frame, LumaPixels luma, double deviation) {
    Random random(frame, 0);
    change_each(luma, [&](double grey, int, int) { return grey + deviation * random.normal(); });
}

void noisy(std::uint64_t frame, LumaPixels, DepthPixels depth) {
    Random random(frame, 1);
    change_each(depth, [&](double z, int, int) { return z * (1 + 0.012 * random.normal()); });
}

/// The disparity of a structured-light camera comes in steps: 6 mm of depth at 1 m.
void coarse(std::uint64_t, LumaPixels, DepthPixels depth) {
    change_each(depth, [](double z, int, int) {
        const double step = std::max(6e-6 * z * z, 1.0); // millimetres
        return std::floor(z / step + 0.5) * step;
    });
}

void short_range(std::uint64_t, LumaPixels, DepthPixels depth) {
    change_each(depth, [](double z, int, int) { return z > 2500 ? 0 : z; });
}

/// A quarter of the cells of 24 x 24 pixels, other ones in each frame.
void patchy(std::uint64_t frame, LumaPixels, DepthPixels depth) {
    constexpr int cell = 24;
    constexpr std::uint64_t cells_across = 4096;
    change_each(depth, [&](double z, int u, int v) {
        const auto at = cells_across * static_cast<std::uint64_t>(v / cell) +
                        static_cast<std::uint64_t>(u / cell);
        return mix(mix(frame + 1) + at) % 4 == 0 ? 0 : z;
    });
}

void shifted(std::uint64_t, LumaPixels, DepthPixels depth) {
    constexpr int right = 4, down = 2;
    for (int v = depth.height() - 1; v >= 0; --v)
        for (int u = depth.width() - 1; u >= 0; --u)
            depth(u, v) =
                depth.contains(u - right, v - down) ? depth(u - right, v - down) : std::uint16_t{0};
}

void grainy(std::uint64_t frame, LumaPixels luma, DepthPixels) {
    add_noise(frame, luma, 8);
}

void dim(std::uint64_t frame, LumaPixels luma, DepthPixels) {
    change_each(luma, [](double grey, int, int) { return 0.3 * grey; });
    add_noise(frame, luma, 3);
}

/// A lamp on 50 Hz mains flickers at 100 Hz: of a camera at 30 frames a second every third image is
/// as bright as another.
void flickering(std::uint64_t frame, LumaPixels luma, DepthPixels) {
    const double turn = 2 * std::numbers::pi / 3 * static_cast<double>(frame);
    const double factor = 1 + 0.12 * std::sin(turn);
    change_each(luma, [&](double grey, int, int) { return factor * grey; });
}

/// Three means over 5 x 5 pixels: nearly a Gaussian with a deviation of 2.4 pixels.
void blurred(std::uint64_t, LumaPixels luma, DepthPixels) {
    constexpr int passes = 3, reach = 2;
    const auto smooth = [](auto at, int count) {
        std::vector<int> line(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i)
            line[static_cast<std::size_t>(i)] = at(i);
        for (int i = 0; i < count; ++i) {
            double sum = 0;
            for (int k = i - reach; k <= i + reach; ++k)
                sum += line[static_cast<std::size_t>(std::clamp(k, 0, count - 1))];
            at(i) = rounded<std::uint8_t>(sum / (2 * reach + 1));
        }
    };
    for (int pass = 0; pass < passes; ++pass) {
        for (int v = 0; v < luma.height(); ++v)
            smooth([&](int u) -> std::uint8_t & { return luma(u, v); }, luma.width());
        for (int u = 0; u < luma.width(); ++u)
            smooth([&](int v) -> std::uint8_t & { return luma(u, v); }, luma.height());
    }
}

constexpr Alteration all[] = {
    {"noisy", "white noise of 1.2 % of the depth", noisy},
    {"coarse", "depth in steps of 6 mm at 1 m, growing with its square", coarse},
    {"short-range", "no depth beyond 2.5 m", short_range},
    {"patchy", "no depth in a quarter of the patches of 24 x 24 pixels, others in each frame",
     patchy},
    {"shifted", "depth 4 pixels too far right and 2 too far down", shifted},
    {"late", "depth maps of the image before", nullptr},
    {"grainy", "images with a noise of 8 grey values", grainy},
    {"dim", "images with 0.3 of the light and a noise of 3 grey values", dim},
    {"flickering", "of three images one as it was, one 10 % brighter, one 10 % darker", flickering},
    {"blurred", "images blurred by 2.4 pixels (one sigma)", blurred},
};

} // namespace

std::span<const Alteration> alterations() {
    return all;
}

const Alteration *find_alteration(std::string_view name) {
    const auto *const found = std::ranges::find(all, name, &Alteration::name);
    return found == std::end(all) ? nullptr : found;
}

bool FrameAlterer::alter(ImageView<std::uint8_t> luma, DepthMap &depth) {
    const std::uint64_t frame = frame_++;
    if (alteration_.change) {
        alteration_.change(frame, luma, depth);
        return true;
    }
    std::swap(before_, depth);
    return frame > 0;
}

} // namespace afterglow
