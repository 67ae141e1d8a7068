// SPDX-License-Identifier: Apache-2.0
#include "eval/live/live_picture.hpp"

#include "tools/picture/depth_colors.hpp"
#include "tools/picture/error_colors.hpp"
#include "tools/picture/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace afterglow {
namespace {

constexpr Rgb background{18, 20, 24};
constexpr Rgb foreground{214, 218, 224};
constexpr int margin = 24;
constexpr int text_scale = 2;
constexpr int caption = text_height * text_scale + 12;

Image<Rgb> luma_panel(LumaView luma) {
    Image<Rgb> panel(luma.width(), luma.height());
    for (int v = 0; v < luma.height(); ++v)
        for (int u = 0; u < luma.width(); ++u)
            panel(u, v) = {luma(u, v), luma(u, v), luma(u, v)};
    return panel;
}

void place(ImageView<Rgb> picture, int u, int v, ImageView<const Rgb> panel,
           const std::string &text) {
    for (int row = 0; row < panel.height(); ++row)
        std::copy_n(panel.row(row), panel.width(), picture.row(v + row) + u);
    draw_text(picture, u, v + panel.height() + 6, text, foreground, text_scale);
}

/// A bar that explains the error's colours, right-aligned at `right`, in the caption's line.
void place_scale(ImageView<Rgb> picture, int right, int v) {
    constexpr int width = 120;
    constexpr int height = 7 * text_scale;
    const std::string end = fmt::format("{:.0f} %", largest_error_shown);
    const int text_width = static_cast<int>(end.size()) * text_advance * text_scale;
    const int left = right - text_width - 8 - width;
    draw_text(picture, left - 2 * text_advance * text_scale, v, "0", foreground, text_scale);
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column)
            if (picture.contains(left + column, v + row))
                picture(left + column, v + row) = error_color(largest_error_shown * column / width);
    draw_text(picture, right - text_width, v, end, foreground, text_scale);
}

} // namespace

Image<Rgb> live_picture(const LiveExample &e) {
    const int width = e.luma.width();
    const int height = e.luma.height();
    Image<Rgb> picture(2 * width + 3 * margin, 2 * (height + caption) + 3 * margin, background);
    const int right = width + 2 * margin;
    const int below = height + caption + 2 * margin;
    const DepthRange range = depth_range(e.measured);

    place(picture, margin, margin, luma_panel(e.luma).view(), "image");
    place(picture, right, margin, color_depth(e.measured, range).view(),
          fmt::format("measured {} frame{} before, {:.1f} to {:.1f} m", e.age_frames,
                      e.age_frames == 1 ? "" : "s", range.near_mm / 1000, range.far_mm / 1000));
    place(picture, margin, below, color_depth(e.estimated, range).view(),
          fmt::format("estimated, light off: {:.0f} % covered", e.coverage));
    place(picture, right, below, color_error(e.estimated, e.truth).view(),
          fmt::format("error, mean {:.2f} %", e.mre));
    place_scale(picture, right + width, below + height + 6);
    return picture;
}

} // namespace afterglow
