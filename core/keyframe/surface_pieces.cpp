// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_tiles.hpp"

#include <algorithm>
#include <bit>

namespace afterglow {
namespace {

constexpr int tile_count(int pixels) {
    return (pixels + SurfaceTiles::tile_px - 1) / SurfaceTiles::tile_px;
}

} // namespace

SurfaceTiles::SurfaceTiles(int width, int height)
    : tiles_(tile_count(width), tile_count(height)), least_(static_cast<std::size_t>(width)),
      nearest_(least_.size()), farthest_(least_.size()), edge_(least_.size()) {}

// Depths are not negative, so their bits are in their order; less one, no depth is beyond all.
void SurfaceTiles::find(ImageView<const float> z, ImageView<const std::uint8_t> edge_distance) {
    const std::size_t width = least_.size();
    std::uint32_t *const least = least_.data(), *const nearest = nearest_.data(),
                         *const farthest = farthest_.data();
    std::uint8_t *const edge = edge_.data();
    for (int y = 0; y < tiles_.height(); ++y) {
        std::ranges::fill(least_, 0xffffffffu);
        std::ranges::fill(nearest_, 0xffffffffu);
        std::ranges::fill(farthest_, 0u);
        std::ranges::fill(edge_, std::uint8_t{255});
        for (int v = y * tile_px; v < std::min((y + 1) * tile_px, z.height()); ++v) {
            const float *const depths = z.row(v);
            const std::uint8_t *const distances = edge_distance.row(v);
            for (std::size_t u = 0; u < width; ++u) {
                const auto bits = std::bit_cast<std::uint32_t>(depths[u]);
                least[u] = std::min(least[u], bits);
                nearest[u] = std::min(nearest[u], bits - 1);
                farthest[u] = std::max(farthest[u], bits);
            }
            for (std::size_t u = 0; u < width; ++u)
                edge[u] = std::min(edge[u], distances[u]);
        }
        for (int x = 0; x < tiles_.width(); ++x) {
            const auto begin = static_cast<std::size_t>(x) * tile_px;
            const std::size_t end = std::min(begin + tile_px, width);
            std::uint32_t l = least[begin], n = nearest[begin], f = farthest[begin];
            std::uint8_t e = edge[begin];
            for (std::size_t u = begin + 1; u < end; ++u) {
                l = std::min(l, least[u]);
                n = std::min(n, nearest[u]);
                f = std::max(f, farthest[u]);
                e = std::min(e, edge[u]);
            }
            tiles_(x, y) = {std::bit_cast<float>(n + 1), std::bit_cast<float>(f), e, l != 0};
        }
    }
}

} // namespace afterglow
