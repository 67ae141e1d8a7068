// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

namespace afterglow {

/// Side of the square tiles of a view, pixels.
constexpr int mapped_tile_px = 16;
/// Side of the square blocks of a tile, pixels.
constexpr int mapped_block_px = 4;
/// If all corners of a block are at least so many pixels from depth edges, no edge crosses it.
constexpr int edge_free_block = 3;
/// Points that are displaced by no more than this against each other hide nothing of each other,
/// pixels.
constexpr float alike_displacement_px = 1.0f;

/// What is seen at a corner of a tile: the pixel (u, v) of a surface, whose depth there is z,
/// metres. A point that is seen at the corner with another depth z' reads scale z' + shift,
/// millimetres.
struct MappedCorner {
    float u = 0, v = 0, z = 0, scale = 0, shift = 0;
};

/// Where a tile's pixels are on a surface: bilinear between the corners, which are at the first
/// pixels of the tile and of the next ones: at the left and right, then below.
struct MappedTile {
    MappedCorner corners[4];
    /// The corners and what is between them are on one surface. If not, the corners have the depth
    /// 1 / inverse_depth, and points of other depths are displaced by their parallax.
    bool one_surface = true;
    /// Readings may be interpolated between nodes. Holes of up to 3 pixels, between two nodes, are
    /// then drawn over.
    bool interpolated = true;
    /// Pixels of the surface times metres: a point whose inverse depth is w more than that of the
    /// corners is seen where these put the pixel that is parallax w farther right and down.
    float parallax_u = 0, parallax_v = 0;
    float inverse_depth = 0; ///< of the corners, 1/m, if not one surface
    /// Points are displaced so differently that the one of a pixel has to be searched for: from the
    /// nearest depth, which is that of the corners, on; where nothing is there, at the farthest.
    bool searched = false;
    float farthest_inverse_depth = 0; ///< 1/m

    /// Columns and rows by which a point is displaced whose inverse depth is 1 / m more.
    float parallax_px() const { return std::abs(parallax_u) + std::abs(parallax_v); }
};

/// Bounds of the readings that were drawn on a tile. They are known only of tiles whose pixels all
/// have one edge distance, or are all empty.
struct TileReadings {
    std::uint8_t edge_distance = 0; ///< of all pixels, pixels; 0: all are empty
    /// Bounds of all pixels' readings, millimetres; nearest > farthest: not known.
    std::uint16_t nearest = 0xffff, farthest = 0;

    static TileReadings empty() { return {.edge_distance = 0, .nearest = 0, .farthest = 0}; }
    bool known() const { return nearest <= farthest; }
};

} // namespace afterglow
