// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/warp/mapped_tile.hpp"

#include <cstdint>

namespace afterglow {

/// Draws the pixels of those blocks of a tile of which `even` is 0: each shows the nearest point of
/// the surface `z` (DepthSurface::z(), at least 2 rows and columns), at the point's own depth. A
/// pixel whose point is searched for shows nothing if the last one found is not seen there: what is
/// behind it was hidden. If the tile is turned and scaled against the surface by less than a third,
/// four pixels of a row show four points of a row, so that none is farther from its place than a
/// pixel. Points nearer to an edge than `least_edge_distance` are left out.
///
/// Writes readings, millimetres, and edge distances, pixels, both 0 = none. Before the call both
/// have to be 0 in uneven blocks, and edge distances not 0 in even blocks, as
/// BlockGrid::draw_even() leaves them. The images begin at the tile's first pixel, `even` at its
/// first block. Returns how many pixels of uneven blocks have depth. Real-time safe.
int draw_uneven_blocks(const MappedTile &tile, const ImageView<const float> &z,
                       int least_edge_distance, const ImageView<const std::uint8_t> &even,
                       const ImageView<std::uint16_t> &millimetres,
                       const ImageView<std::uint8_t> &edge_distance);

} // namespace afterglow
