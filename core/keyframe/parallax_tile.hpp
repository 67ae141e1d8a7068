// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/keyframe/mapped_tile.hpp"

#include <cstdint>

namespace afterglow {

/// look_up_nodes() and draw_uneven_blocks() of a tile that is not of one surface. Real-time safe.
void look_up_nodes_by_parallax(const MappedTile &tile, ImageView<const float> z,
                               int least_edge_distance, const BlockNodes &nodes);
int draw_uneven_by_parallax(const MappedTile &tile, ImageView<const float> z,
                            int least_edge_distance, ImageView<const std::uint8_t> even,
                            ImageView<std::uint16_t> millimetres,
                            ImageView<std::uint8_t> edge_distance);

} // namespace afterglow
