// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Depths and edges of a part of a surface: nothing, a piece or several. Each value is kept as a
/// number whose maximum counts, so that one vector instruction adds another part.
class SurfacePart {
public:
    static constexpr std::size_t values = 4;
    SurfacePart() = default; ///< nothing
    /// Depths in metres, not negative: their bits have the order of the depths.
    SurfacePart(float nearest, float farthest, int least_edge_distance, bool holes)
        : most_{~std::bit_cast<std::uint32_t>(nearest), std::bit_cast<std::uint32_t>(farthest),
                ~static_cast<std::uint32_t>(least_edge_distance), holes} {}

    void add(const SurfacePart &other) {
        for (std::size_t i = 0; i < most_.size(); ++i)
            most_[i] = std::max(most_[i], other.most_[i]);
    }
    float nearest() const { return std::bit_cast<float>(~most_[0]); }
    float farthest() const { return std::bit_cast<float>(most_[1]); } ///< 0: nothing is seen
    int least_edge_distance() const { return static_cast<int>(~most_[2]); }
    bool holes() const { return most_[3] != 0; }
    /// For kernels: the greater one of each value is what two parts have together.
    std::array<std::uint32_t, values> &most() { return most_; }
    const std::array<std::uint32_t, values> &most() const { return most_; }

private:
    alignas(16) std::array<std::uint32_t, values> most_{};
};

/// Square pieces of a surface, so that what is alike all over one of them is done for all of it at
/// once.
///
/// Allocates when made; find() is real-time safe.
class SurfacePieces {
public:
    static constexpr int piece_px = 8;
    static constexpr std::uint8_t has_holes = 8; ///< beside an edge distance
    SurfacePieces(int width, int height);

    /// `z`: as DepthSurface::z().
    void find(ImageView<const float> z);

    // One pixel for each piece; those at the right and below may have fewer than piece_px^2 pixels.

    /// Least and greatest depth, metres; both 0 where a piece has none.
    ImageView<const float> nearest() const { return nearest_; }
    ImageView<const float> farthest() const { return farthest_; }
    /// The same of pieces that have depth, and the least edge distance of the pixels that have; a
    /// piece has holes if some of its pixels, or all of one beside it, have none.
    ImageView<const SurfacePart> parts() const { return parts_; }
    /// The least depth of one of the nearest pieces around pixel (u, v) that have any; 0 where none
    /// has within 3 pieces.
    float nearest_around(int u, int v) const;

private:
    void mark_beside_holes();
    void find_parts();

    Image<float> nearest_, farthest_;
    /// Least edge distance, 0 = no depth, and has_holes.
    Image<std::uint8_t> edges_;
    Image<SurfacePart> parts_;
};

} // namespace afterglow
