// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/warp.hpp"

#include <Eigen/Core>

#include <cstdint>

namespace afterglow {

/// Points of one row: depths in metres, 0 = none, of the row and of those above and below.
struct PointRow {
    const float *z; ///< begins one pixel early and ends one late
    const float *above, *below;
    const std::uint8_t *edge_distance;
    int first_column, count;
};

/// Takes the point of column u with depth z to z (u by_column + origin) + shift, homogeneous
/// pixels.
struct RowProjection {
    Eigen::Vector3f by_column, origin, shift;
};

/// Moves a point at the homogeneous pixel h by the share t of what happens while the picture is
/// read: h + t (turn h + shift), where t = (row - middle) per_row.
struct RowMotion {
    Eigen::Matrix3f turn;
    Eigen::Vector3f shift;
    float middle, per_row;
    bool any; ///< else nothing moves
};

/// What lands: points inside the picture (pixels) and between the depths (metres).
struct LandingLimits {
    float nearest, farthest, width, height;
    int least_edge_distance;
    int hides_below; ///< edge distance of points that land as near as the nearest of their
                     ///< neighbours
    int stride;      ///< of the map that is landed on
};

/// Where each point lands, as an offset into a map, and what it leaves there; a point that does not
/// land leaves nothing_landed at offset 0. Its depth is moved to the pixel's centre along the slope
/// of the surface. Real-time safe, like find_doubtful().
void project_points(const PointRow &points, const RowProjection &projection,
                    const RowMotion &motion, const LandingLimits &limits, int *offsets,
                    WarpedPixel *values);

/// Three rows of a scattered map, which can be read one pixel beyond either end.
struct ScatteredRows {
    const WarpedPixel *above, *row, *below;
    int count;
};

/// Copies the row to `out`, 0 where nothing landed, and sets `doubtful` to 1 where it may have a
/// crack, else 0. Pixels of which `taken` is not 0 have none.
void find_doubtful(const ScatteredRows &scattered, const std::uint16_t *taken, WarpedPixel *out,
                   std::uint8_t *doubtful);

/// Pixels of a row of a warped map, and what takes their depths to readings: those are the depths
/// by 1 + shape . (x, y, x^2 + y^2), DepthCorrection's, at x = x0 + dx u.
struct WarpedRow {
    const WarpedPixel *pixels;
    int first_column, count;
    float x0, dx, y;
    Eigen::Vector3f shape;
};
/// Bins of readings are so long, metres, and as many; the last one has what is farther, too.
constexpr float reading_bin_m = 0.1f;
constexpr int reading_bins = 128;

/// The reading of each pixel, millimetres, and its class: the edge distance times reading_bins, and
/// the bin. Those of empty pixels mean nothing. Real-time safe.
void find_readings(const WarpedRow &row, std::uint16_t *millimetres, std::uint16_t *classes);

} // namespace afterglow
