// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/surface_kernels.hpp"

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// What becomes a crack's: points of one surface (EdgeRule) on opposite sides of it, with at most
/// `widest` pixels (1 or 2) between them.
struct CrackRule {
    int widest;
    EdgeRule surface;
};
/// Fills the cracks in `count` points of a row (for_each_pair_across()): where a point is not
/// inside a surface, but lies between two that are, one of them its neighbour and the other at most
/// two pixels away, it becomes the mean over all directions of what lies between the two on one
/// surface, metres, with an edge distance of `beside_edge`. `inside`: 1 where a point, which has
/// depth, is inside a surface, else 0. Rows of both are `stride` points apart; two more rows and
/// columns are read on each side. Real-time safe.
void fill_cracks_of_row(const std::uint8_t *inside, std::ptrdiff_t stride, int count,
                        const CrackRule &rule, float *points);

} // namespace afterglow
