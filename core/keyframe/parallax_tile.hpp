// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/keyframe/mapped_tile.hpp"

#include <cstdint>

namespace afterglow {

/// draw_mapped() of a tile that is not of one surface. Real-time safe.
int draw_by_parallax(const MappedTile &tile, ImageView<const float> z, int least_edge_distance,
                     ImageView<std::uint16_t> millimetres, ImageView<std::uint8_t> edge_distance);

} // namespace afterglow
