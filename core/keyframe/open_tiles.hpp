// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace afterglow {

/// Where a depth map still has room: square tiles of the picture with at least one empty pixel.
///
/// Allocates when made; the calls are real-time safe.
class OpenTiles {
public:
    static constexpr int tile_px = 16;

    OpenTiles(int width, int height);

    void find(DepthView depth);

    /// Whether any tile that touches the pixels from (u0, v0) to (u1, v1), both included, is open.
    /// They may lie outside the picture, which has no tiles.
    bool any(float u0, float v0, float u1, float v1) const;

    /// Calls visit(begin, end) for each run of open pixels of row v, whole tiles.
    template <class Visit>
    void for_each_run(int v, const Visit &visit) const {
        const std::uint8_t *open = open_.row(v / tile_px);
        for (int t = 0; t < open_.width(); ++t) {
            if (!open[t])
                continue;
            const int begin = t;
            while (t < open_.width() && open[t])
                ++t;
            visit(begin * tile_px, std::min(t * tile_px, width_));
        }
    }

private:
    int width_, height_;
    Image<std::uint8_t> open_;
    Image<int> before_; ///< open tiles above and left of each corner of a tile
};

} // namespace afterglow
