// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/open_tiles.hpp"

namespace afterglow {
namespace {

constexpr int tiles_for(int pixels) {
    return (pixels + OpenTiles::tile_px - 1) / OpenTiles::tile_px;
}

} // namespace

OpenTiles::OpenTiles(int width, int height)
    : width_(width), height_(height), open_(tiles_for(width), tiles_for(height)),
      before_(open_.width() + 1, open_.height() + 1) {}

void OpenTiles::find(DepthView depth) {
    std::ranges::fill(open_.pixels(), std::uint8_t{0});
    for (int v = 0; v < height_; ++v) {
        const std::uint16_t *begin = depth.row(v);
        const std::uint16_t *const row_end = begin + width_;
        std::uint8_t *open = open_.row(v / tile_px);
        for (int t = 0; t < open_.width(); ++t) {
            const std::uint16_t *const end =
                begin + std::min<std::ptrdiff_t>(tile_px, row_end - begin);
            if (!open[t])
                open[t] = std::find(begin, end, std::uint16_t{0}) != end;
            begin = end;
        }
    }
    for (int y = 0; y < open_.height(); ++y)
        for (int x = 0; x < open_.width(); ++x)
            before_(x + 1, y + 1) =
                before_(x, y + 1) + before_(x + 1, y) - before_(x, y) + open_(x, y);
}

bool OpenTiles::any(float u0, float v0, float u1, float v1) const {
    if (!(u1 >= 0 && v1 >= 0 && u0 < static_cast<float>(width_) &&
          v0 < static_cast<float>(height_)))
        return false;
    const int x0 = static_cast<int>(std::max(u0, 0.0f)) / tile_px;
    const int y0 = static_cast<int>(std::max(v0, 0.0f)) / tile_px;
    const int x1 = static_cast<int>(std::min(u1, static_cast<float>(width_ - 1))) / tile_px + 1;
    const int y1 = static_cast<int>(std::min(v1, static_cast<float>(height_ - 1))) / tile_px + 1;
    return before_(x1, y1) - before_(x0, y1) - before_(x1, y0) + before_(x0, y0) > 0;
}

} // namespace afterglow
