// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/sensor_noise.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>

namespace afterglow {

/// Pixels of one row of a depth map in metres, 0 = none, with at least `radius` rows and columns of
/// the map around them.
struct SmoothedRow {
    const float *z;        ///< the first of them
    std::ptrdiff_t stride; ///< of the map
    int radius, count;
};

/// Means over windows of what lies on the surface of each pixel, as DepthSurface::smooth() has them
/// where all readings are alike. Real-time safe.
void smooth_row(const SmoothedRow &in, const SensorNoise &noise, float *out);

/// Readings of one row, millimetres, and what makes them depths: times 1 + shape . (x, y, x^2 +
/// y^2), DepthCorrection's, at x = x0 + dx u for column u. Depths outside are none, metres.
struct ReadingRow {
    const std::uint16_t *millimetres;
    int count;
    float x0, dx, y;
    Eigen::Vector3f shape;
    float nearest_m, farthest_m;
};
/// The depths, metres, 0 = none. Returns how many there are. Real-time safe.
int load_row(const ReadingRow &in, float *z);

/// Lowers each distance to one more than that of the next row: values[i] = min(values[i],
/// next[i] + 1). Real-time safe.
void grow_from_row(const std::uint8_t *next, int count, std::uint8_t *values);

/// What parts two surfaces: a step between neighbours of more than `edge_relative` of the nearer
/// depth and three sigmas of noise.
struct EdgeRule {
    float edge_relative;
    SensorNoise noise;
};
/// How a pixel and the next one of a row or column are to each other.
enum class Neighbours : std::uint8_t {
    alike = 0,  ///< on one surface, or the pixel is empty
    parted = 1, ///< on two surfaces
    hole = 2,   ///< the next one is empty
};
/// Of pairs on one surface: how many, and the sum of max(0, |dz| - sigma) / z in 2^-20.
struct Slopes {
    int pairs = 0;
    std::int64_t sum = 0;
};
/// Compares `count` pixels with as many next ones. Depths in metres, 0 = none.
/// Real-time safe.
Slopes compare_neighbours(const float *pixels, const float *next, int count, const EdgeRule &rule,
                          Neighbours *found);

} // namespace afterglow
