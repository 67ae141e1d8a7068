// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/sensor_noise.hpp"

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// A depth in whole units of a map: 1 / DepthUnits::per_metre; 0 = none.
using UnitDepth = std::int16_t;

/// The fraction of a metre that a map's depths are counted in: half a millimetre as far as it
/// reaches, else one. Sums of two depths less twice a third stay clear of 2^16, so that what
/// overflows is never taken for a small difference.
struct DepthUnits {
    static constexpr float farthest_m = 30.0f;
    static constexpr float farthest_of_halves_m = 15.0f;

    explicit DepthUnits(float reach_m) : halves(reach_m <= farthest_of_halves_m) {}

    bool halves; ///< of millimetres

    int per_millimetre() const { return halves ? 2 : 1; }
    float per_metre() const { return halves ? 2000.0f : 1000.0f; }
    float metres() const { return halves ? 0.0005f : 0.001f; }
};

/// Six times a sensor's sigma() of depths in a map's units, as a sum of 16-bit fixed-point
/// products. Where a factor is 1 or more, all are divided by a power of two, and the sum is doubled
/// as often.
struct SixSigmaFactors {
    SixSigmaFactors(const SensorNoise &noise, const DepthUnits &units);

    int doublings = 0;
    std::int16_t floor, linear, quadratic, least;
};

/// Kernels read this many depths, flags and steps past the end of a row. What is there is not used.
constexpr int row_slack = 16;

/// Readings of one row, millimetres, and what makes them depths: a reading d becomes d + d
/// (by_column + by_row) / 2^15. Depths outside are none.
struct ReadingRow {
    const std::uint16_t *millimetres;
    int count;
    const std::int16_t *by_column; ///< null: readings are depths
    std::int16_t by_row;
    UnitDepth nearest, farthest;
};
/// The depths, 0 = none. Returns how many there are. Real-time safe.
int load_row(const ReadingRow &in, const DepthUnits &units, UnitDepth *z);

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

/// Five rows, 1 where a pixel is inside a surface; they can be read two pixels beyond either end.
struct InsideRows {
    const std::uint8_t *above2, *above, *row, *below, *below2;
};
/// Sets `cracks` to 1 where a pixel is not inside a surface, but lies between two that are, one of
/// them its neighbour and the other at most two pixels away, else to 0. Real-time safe.
void find_cracks(const InsideRows &inside, int count, std::uint8_t *cracks);

/// Pixels of one row of a map, with at least `radius` rows and columns of the map around them.
struct SmoothedRow {
    const UnitDepth *z;    ///< the first of them
    std::ptrdiff_t stride; ///< of the map
    int radius, count;     ///< the radius is 1 to 8
};
/// Metres: means over windows of what lies on the surface of each pixel, as SurfaceSmoothing has
/// them where all readings are of one amplitude. Real-time safe.
void smooth_row(const SmoothedRow &in, const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                float *out);

/// Smoothing with a radius of 2 in two passes, which is nearly the same for a third of the work.
/// The first: each of `count` readings becomes the mean over five of its row, in whole units, less
/// one: no reading is 2^16 - 1. Two readings before `z` and two behind the last are read.
void smooth_row_across(const UnitDepth *z, int count, const SixSigmaFactors &six_sigmas,
                       std::uint16_t *out);
/// The second: each reading becomes the mean over five rows of such means, metres, as a point of a
/// surface (with_edge_distance()). Rows are `stride` readings apart; two above `z` and two below
/// are read. Both are real-time safe.
void smooth_row_down(const std::uint16_t *z, std::ptrdiff_t stride, int count,
                     const SixSigmaFactors &six_sigmas, const DepthUnits &units,
                     const std::uint8_t *edge_distance, float *out);

} // namespace afterglow
