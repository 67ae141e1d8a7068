// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/warp/mapped_tile.hpp"

#include <cstdint>

namespace afterglow {

/// Draws the mapped tiles of a view.
///
/// Tiles are parted into blocks. First what is seen at the *nodes* is looked up, the first pixels
/// of all blocks. A block is *even* if its four corners, nodes of its own and of its neighbours,
/// show one surface, `edge_free_block` pixels or more from edges, and if parallax displaces them
/// by less than `alike_displacement_px` against each other. Even blocks get readings that are
/// bilinear between their corners and the mean of their edge distances; holes of up to 3 pixels,
/// between two nodes, are drawn over. The pixels of uneven blocks are looked up one by one
/// (draw_uneven_blocks()).
///
/// Allocates when made; the calls are real-time safe.
class BlockGrid {
public:
    /// Of a view of so many pixels; tiles that are not wholly in it cannot be mapped.
    BlockGrid(int width, int height);

    int columns() const { return columns_; } ///< of whole tiles
    int rows() const { return rows_; }

    /// Looks up the nodes of a tile of the surface `z` (DepthSurface::z(), at least 2 rows and
    /// columns). Points nearer to an edge than `least_edge_distance` are left out. Different tiles
    /// may be looked up at the same time.
    void look_up(int x, int y, const MappedTile &tile, const ImageView<const float> &z,
                 int least_edge_distance);
    /// A tile that is not mapped has no nodes.
    void leave_out(int x, int y);

    /// When all tiles have been looked up or left out: draws the even blocks of a row of tiles:
    /// readings, millimetres, and edge distances, pixels. Uneven blocks, and all of tiles that were
    /// left out, become empty (both 0). Rows of tiles may be drawn at the same time.
    void draw_even(int y, ImageView<std::uint16_t> millimetres,
                   ImageView<std::uint8_t> edge_distance);
    /// Then: draws the uneven blocks of a tile that was looked up. Returns how many pixels of the
    /// whole tile have depth.
    int draw_uneven(int x, int y, const MappedTile &tile, const ImageView<const float> &z,
                    int least_edge_distance, const ImageView<std::uint16_t> &millimetres,
                    const ImageView<std::uint8_t> &edge_distance) const;
    /// Of what draw_even() has drawn on a tile: known if all of its blocks are even and have one
    /// edge distance.
    const TileReadings &readings(int x, int y) const { return readings_(x, y); }

private:
    static constexpr int blocks_across = mapped_tile_px / mapped_block_px;

    int columns_, rows_;
    Image<std::uint16_t> millimetres_; ///< of the nodes, 0: nothing is seen
    Image<std::uint8_t> edge_distance_;
    Image<std::int16_t> displacement_; ///< BlockNodes::displacement
    /// By column of blocks and row of tiles: a block is not even if its corners are displaced by so
    /// much against each other, or more; the unit is that of displacement_.
    Image<std::int16_t> most_displaced_;
    Image<std::uint8_t> even_;     ///< by block: its mean edge distance; 0: not even
    Image<TileReadings> readings_; ///< by tile
};

} // namespace afterglow
