// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>

namespace afterglow {

/// Square pieces of a surface, so that what is alike all over one of them is done for all of it at
/// once.
///
/// Allocates when made; find() is real-time safe.
class SurfacePieces {
public:
    static constexpr int piece_px = 4;

    SurfacePieces(int width, int height);

    /// `z`: metres, 0 = none; `edge_distance`: pixels.
    void find(ImageView<const float> z, ImageView<const std::uint8_t> edge_distance);

    // One pixel for each piece; those at the right and below may have fewer than piece_px^2 pixels.

    /// Least and greatest depth, metres; both 0 where a piece has none.
    ImageView<const float> nearest() const { return nearest_; }
    ImageView<const float> farthest() const { return farthest_; }
    /// Least edge distance, pixels; 0 where a pixel of the piece has no depth.
    ImageView<const std::uint8_t> edge_distance() const { return edge_distance_; }

private:
    Image<float> nearest_, farthest_;
    Image<std::uint8_t> edge_distance_;
};

} // namespace afterglow
