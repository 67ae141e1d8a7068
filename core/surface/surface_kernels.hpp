// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/sensor_noise.hpp"
#include "core/surface/unit_depth.hpp"

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Readings of one row, millimetres, and what makes them depths: a reading d becomes d + d
/// (by_column + by_row) / 2^15. Depths outside are none.
struct ReadingRow {
    const std::uint16_t *millimetres;
    int count;
    const std::int16_t *by_column; ///< null: readings are depths
    std::int16_t by_row;
    UnitDepth nearest, farthest;
};
/// The depths, 0 = none. Real-time safe.
void load_row(const ReadingRow &in, const DepthUnits &units, UnitDepth *z);

/// What parts two surfaces: a step between neighbours of more than `edge_relative` of the nearer
/// depth and three sigmas of noise.
struct EdgeRule {
    float edge_relative;
    SensorNoise noise;
};
/// About twice the step that parts a surface at each depth from a further one (EdgeRule), units; 0
/// where there is no depth. Writes whole vectors: up to row_slack more. Real-time safe.
void find_steps(const UnitDepth *z, int count, float edge_relative,
                const SixSigmaFactors &six_sigmas, std::int16_t *steps);

/// A row of depths and the steps found for it.
struct SteppedRow {
    const UnitDepth *z;
    const std::int16_t *steps;
};
/// What may part a pixel from the next one: another surface or a hole.
enum : std::uint8_t { parted_from_right = 1, parted_from_below = 2 };
/// Flags the pixels of `row` that have depth and whose neighbour to the right (the last one's is
/// whatever follows) or below has none, or one that differs by more than the smaller of both steps.
/// Real-time safe.
void compare_neighbours(const SteppedRow &row, const SteppedRow &below, int count,
                        std::uint8_t *flags);

/// Of pairs on one surface: how many, and the sum of min(1, max(0, |dz| - sigma) / z).
struct Slopes {
    int pairs = 0;
    float sum = 0;
};
/// Compares `count` pixels with as many next ones. Real-time safe.
Slopes find_slopes(const UnitDepth *pixels, const UnitDepth *next, int count, const EdgeRule &rule,
                   const DepthUnits &units);

/// Lowers each distance to one more than that of the next row: values[i] = min(values[i],
/// next[i] + 1). Real-time safe.
void grow_from_row(const std::uint8_t *next, int count, std::uint8_t *values);

} // namespace afterglow
