// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/surface_kernels.hpp"

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Which points of a row are inside a surface: 1 where there is depth and no edge (an edge distance
/// of 1), else 0. Real-time safe.
void find_inside(const UnitDepth *z, const std::uint8_t *edge_distance, int count,
                 std::uint8_t *inside);

/// What fills a crack: points of one surface (EdgeRule) on opposite sides of it, with at most
/// `widest` pixels (1 or 2) between them.
struct CrackRule {
    int widest;
    EdgeRule surface;
};
/// Fills the cracks in `count` points of a row (for_each_pair_across()): where a point is not
/// inside a surface, but lies between two that are, one of them its neighbour and the other at most
/// two pixels away, it becomes the mean over all directions of what lies between the two on one
/// surface, metres, with an edge distance of `beside_edge`. `inside`: as find_inside() finds it.
/// Rows of both are `stride` points apart; two more rows and columns are read on each side.
/// Real-time safe.
void fill_cracks_of_row(const std::uint8_t *inside, std::ptrdiff_t stride, int count,
                        const CrackRule &rule, float *points);

} // namespace afterglow
