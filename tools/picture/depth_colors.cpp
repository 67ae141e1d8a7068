// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/depth_colors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace afterglow {
namespace {

constexpr Rgb no_depth = {18, 18, 22};

// Equally spaced along the scale. Lightness rises to yellow and falls again without a dark or a
// garish band between two neighbours, so that edges in the picture are edges in depth.
constexpr Rgb scale[] = {{140, 20, 24},  {212, 56, 28},   {246, 122, 36}, {250, 190, 60},
                         {214, 226, 84}, {134, 218, 116}, {62, 190, 158}, {40, 146, 196},
                         {58, 100, 198}, {74, 58, 160},   {54, 26, 98}};

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double share) {
    return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
}

} // namespace

Rgb interpolate(std::span<const Rgb> stops, double place) {
    const auto last = static_cast<int>(stops.size()) - 1;
    const double at = (place > 0 ? std::min(place, 1.0) : 0.0) * last;
    const auto i = static_cast<std::size_t>(std::min(static_cast<int>(at), last - 1));
    const double share = at - static_cast<double>(i);
    const Rgb &a = stops[i];
    const Rgb &b = stops[i + 1];
    return {mix(a.red, b.red, share), mix(a.green, b.green, share), mix(a.blue, b.blue, share)};
}

Rgb color_scale(double place) {
    return interpolate(scale, place);
}

Rgb depth_color(std::uint16_t depth_mm, double near_mm, double far_mm) {
    if (depth_mm == 0)
        return no_depth;
    return color_scale((depth_mm - near_mm) / std::max(far_mm - near_mm, 1.0));
}

DepthRange depth_range(DepthView depth) {
    std::vector<std::uint16_t> known;
    for (int v = 0; v < depth.height(); ++v)
        std::copy_if(depth.row(v), depth.row(v) + depth.width(), std::back_inserter(known),
                     [](std::uint16_t mm) { return mm != 0; });
    if (known.empty())
        return {};
    const auto percentile = [&](std::size_t percent) {
        const auto nth = known.begin() + static_cast<std::ptrdiff_t>(known.size() * percent / 100);
        std::nth_element(known.begin(), nth, known.end());
        return static_cast<double>(*nth);
    };
    return {percentile(2), percentile(98)};
}

Image<Rgb> color_depth(DepthView depth, const DepthRange &range) {
    Image<Rgb> colors(depth.width(), depth.height());
    for (int v = 0; v < depth.height(); ++v)
        std::transform(
            depth.row(v), depth.row(v) + depth.width(), colors.row(v),
            [&](std::uint16_t mm) { return depth_color(mm, range.near_mm, range.far_mm); });
    return colors;
}

} // namespace afterglow
