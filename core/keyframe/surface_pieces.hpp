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
    static constexpr int piece_px = 8;
    static constexpr std::uint8_t has_holes = 8;

    SurfacePieces(int width, int height);

    /// `z`: as DepthSurface::z().
    void find(ImageView<const float> z);

    // One pixel for each piece; those at the right and below may have fewer than piece_px^2 pixels.

    /// Least and greatest depth, metres; both 0 where a piece has none.
    ImageView<const float> nearest() const { return nearest_; }
    ImageView<const float> farthest() const { return farthest_; }
    /// Least edge distance of the pixels that have depth, 0 = none, and has_holes if some pixels of
    /// the piece, or all of one beside it, have none.
    ImageView<const std::uint8_t> edges() const { return edges_; }

private:
    void mark_beside_holes();

    Image<float> nearest_, farthest_;
    Image<std::uint8_t> edges_;
};

} // namespace afterglow
