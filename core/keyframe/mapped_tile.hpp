// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

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

/// What is seen at *nodes*, the first pixels of blocks: readings, millimetres, edge distances,
/// pixels, both 0 = nothing, and by how much parallax displaces the points. The views begin at a
/// tile's first node.
struct BlockNodes {
    ImageView<std::uint16_t> millimetres;
    ImageView<std::uint8_t> edge_distance;
    ImageView<std::int16_t> displacement; ///< 1 / displacement_units pixels, from infinitely far
};
constexpr int displacement_units = 32;

/// Looks up the nodes of a tile of the surface `z` (DepthSurface::z(), at least 2 rows and
/// columns), and those at its right and below, if the views have a further column and row for them.
/// A pixel shows the nearest point of the surface. Its depth is that of the surface at the pixel's
/// place: if the corners are on one surface, the point's, moved along the slope between the
/// corners; else bilinear between the four points around the place, if they are on one surface. A
/// pixel whose point is searched for shows nothing if the last one found is not seen there: what is
/// behind it was hidden. Points nearer to an edge than `least_edge_distance` are left out.
/// Real-time safe.
void look_up_nodes(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                   const BlockNodes &nodes);

/// Draws the pixels of a tile's blocks of which `even` is 0, each looked up as a node is; but of
/// tiles that are not of one surface a pixel has the depth of its point. Writes readings,
/// millimetres, and edge distances, pixels, both 0 = none; the images begin at the tile's first
/// pixel. Returns how many of these pixels have depth. Real-time safe.
int draw_uneven_blocks(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                       ImageView<const std::uint8_t> even, ImageView<std::uint16_t> millimetres,
                       ImageView<std::uint8_t> edge_distance);

} // namespace afterglow
