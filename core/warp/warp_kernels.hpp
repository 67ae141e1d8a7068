// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/surface/surface_pieces.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <span>

namespace afterglow {

/// One pixel of a warped map; 0 = nothing. The high 19 bits below the sign are the depth in 1/16
/// mm, so that integer order is depth order; under them the edge distance.
using WarpedPixel = std::int32_t;
constexpr float warped_units_per_m = 16000.0f;
constexpr int warped_depth_shift = 12;
/// The most that sensor.farthest_m may be: with the move to the pixel's centre it must fit 19 bits.
constexpr float warped_farthest_m = 30.0f;
constexpr WarpedPixel warped_edge_mask = 7;
/// A pixel of the scattered map on which no point has landed.
constexpr WarpedPixel nothing_landed = 0x7fffffff;

inline float warped_z(WarpedPixel p) {
    return static_cast<float>(p >> warped_depth_shift) * (1.0f / warped_units_per_m);
}

/// Most points that are projected at once.
constexpr int most_points = 64;

/// Points of one row, at most most_points, and of those above and below: as DepthSurface::z().
struct PointRow {
    const float *z; ///< begins one pixel early and ends one late
    const float *above, *below;
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
/// crack, else 0.
void find_doubtful(const ScatteredRows &scattered, WarpedPixel *out, std::uint8_t *doubtful);

/// Pixels of a row of a warped map, and the readings that their depths become, relative to the
/// depths: of the first pixel, and by how much that changes to the next one.
struct WarpedRow {
    const WarpedPixel *pixels;
    int count;
    float relative, step;
};

/// The reading of each pixel, millimetres, and its edge distance; both 0 where it is empty. Returns
/// how many are not. Real-time safe.
int find_readings(const WarpedRow &row, std::uint16_t *millimetres, std::uint8_t *edge_distance);

/// Square pieces of one row of a surface: their least and greatest depths, metres, 0 = none.
struct PieceRow {
    const float *nearest, *farthest;
    float first_centre; ///< column in the middle of the first
    float size;         ///< pixels
    int count;
};

/// Where pieces are seen, and what counts.
struct PieceProjection {
    RowProjection row;     ///< of the pieces' centres
    const RowMotion &rows; ///< while the view is read
    Eigen::Matrix3f turn;  ///< SurfaceProjection::turn()
    float nearest;         ///< what is nearer to the view's camera is behind it, metres
    int columns, lines;    ///< tiles of the view
    float margin;          ///< around each piece, pixels of the view
};

/// Tiles of a view, the last ones included; none if left > right or top > bottom.
struct TileRange {
    std::int16_t left, right, top, bottom;
    bool operator==(const TileRange &) const = default;
};

/// The tiles on which each piece may be seen: around the picture of its centre at its nearest and
/// at its farthest depth, as far as half its size reaches. A piece that is partly behind the camera
/// may be seen on all of them. Real-time safe.
void find_tile_ranges(const PieceRow &pieces, const PieceProjection &projection, TileRange *ranges);

/// Adds each part to the tiles of its range. Real-time safe.
void add_to_tiles(const SurfacePart *parts, std::span<const TileRange> ranges,
                  ImageView<SurfacePart> tiles);

} // namespace afterglow
