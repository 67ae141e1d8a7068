// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// What is on a tile of a surface.
struct SurfaceTile {
    float nearest = 0, farthest = 0;      ///< metres; both 0 where it has no depth
    std::uint8_t least_edge_distance = 0; ///< pixels
    bool whole = false;                   ///< every pixel has depth
    bool empty() const { return farthest == 0.0f; }
};

/// Tiles of a surface, so that what is alike all over one of them is done for all of it at once.
///
/// Allocates when made; find() is real-time safe.
class SurfaceTiles {
public:
    static constexpr int tile_px = 8;

    SurfaceTiles(int width, int height);

    /// `z`: metres, 0 = none; `edge_distance`: pixels.
    void find(ImageView<const float> z, ImageView<const std::uint8_t> edge_distance);

    /// Those at the right and below may be smaller than tile_px x tile_px pixels.
    ImageView<const SurfaceTile> view() const { return tiles_; }

private:
    Image<SurfaceTile> tiles_;
    /// Of each column of a row of tiles: the bits of its least value, of its least depth less one,
    /// and of its most; and its least edge distance.
    std::vector<std::uint32_t> least_, nearest_, farthest_;
    std::vector<std::uint8_t> edge_;
};

} // namespace afterglow
