// SPDX-License-Identifier: Apache-2.0
#include "tools/picture/depth_scale.hpp"

#include "tools/picture/text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace afterglow {
namespace {

constexpr Rgb paper = {255, 255, 255};
constexpr Rgb ink = {0, 0, 0};
constexpr int labels = 5;
constexpr int label_length = 7; ///< "65.53 m"

} // namespace

Image<Rgb> depth_scale(const DepthRange &range, int height) {
    const int scale = std::max(1, height / 240);
    const int bar = 12 * scale;
    Image<Rgb> picture(bar + (label_length + 1) * text_advance * scale, height, paper);
    for (int v = 0; v < height; ++v)
        std::fill_n(picture.row(v), bar, color_scale(v / std::max(1.0, height - 1.0)));
    if (range.far_mm <= DepthRange{}.far_mm)
        return picture;
    for (int i = 0; i < labels; ++i) {
        const double share = static_cast<double>(i) / (labels - 1);
        std::array<char, 32> text = {};
        std::snprintf(text.data(), text.size(), "%.2f m",
                      (range.near_mm + share * (range.far_mm - range.near_mm)) / 1000);
        const int v = static_cast<int>(share * (height - text_height * scale));
        draw_text(picture, bar + text_advance * scale, v, text.data(), ink, scale);
    }
    return picture;
}

} // namespace afterglow
