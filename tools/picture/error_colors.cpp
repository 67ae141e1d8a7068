// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/error_colors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace afterglow {
namespace {

constexpr Rgb nothing{8, 8, 10};

} // namespace

Rgb error_color(double percent) {
    constexpr Rgb stops[] = {
        {24, 28, 52}, {86, 36, 98}, {190, 60, 72}, {244, 140, 54}, {252, 232, 160}};
    constexpr int last = static_cast<int>(std::size(stops)) - 1;
    const double place = std::clamp(percent / largest_error_shown, 0.0, 1.0) * last;
    const int below = std::min(static_cast<int>(place), last - 1);
    const double share = place - below;
    const auto mix = [&](std::uint8_t a, std::uint8_t b) {
        return static_cast<std::uint8_t>(std::lround(a + (b - a) * share));
    };
    const Rgb a = stops[below];
    const Rgb b = stops[below + 1];
    return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Image<Rgb> color_error(DepthView estimate, DepthView truth) {
    Image<Rgb> picture(truth.width(), truth.height(), nothing);
    for (int v = 0; v < truth.height(); ++v)
        for (int u = 0; u < truth.width(); ++u)
            if (estimate(u, v) != 0 && truth(u, v) != 0)
                picture(u, v) = error_color(
                    100 * std::abs(1.0 - static_cast<double>(estimate(u, v)) / truth(u, v)));
    return picture;
}

} // namespace afterglow
