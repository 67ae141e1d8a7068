// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/warp/mapped_tile.hpp"

#include <cstdint>

namespace afterglow {

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
void look_up_nodes(const MappedTile &tile, const ImageView<const float> &z, int least_edge_distance,
                   const BlockNodes &nodes);

} // namespace afterglow
