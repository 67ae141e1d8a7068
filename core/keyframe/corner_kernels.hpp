// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/keyframe/surface_pieces.hpp"

#include <Eigen/Core>

namespace afterglow {

/// What is seen on one row of a view. The inverse of SurfaceProjection, but for two things: along
/// parallax a surface's skew is taken to be that of points infinitely far away, and the motion
/// while the view is read is that of the row itself, not of the one on which a point would be
/// without it.
struct ViewRow {
    /// By y depth, a homogeneous pixel (column, row, 1) of the view becomes y (by_column column +
    /// origin) - shift, a homogeneous pixel of the surface.
    Eigen::Vector3f by_column, origin, shift;
    /// How surface pixels turn from its first row to its last one, per row from `middle` on.
    Eigen::Matrix3f turn_per_row;
    float middle;
    bool skewed;
};

/// The points of a surface that are seen at some pixels of a view, an array for each value: one
/// whose depth is z, metres, is at the surface's pixel infinite + parallax / z, and its depth in
/// the view is scale z + shift.
struct ViewRays {
    float *infinite_u, *infinite_v;
    float *parallax_u, *parallax_v; ///< pixels times metres
    float *scale, *shift;           ///< shift in metres

    /// The rays from the i-th on.
    ViewRays from(int i) const {
        return {infinite_u + i, infinite_v + i, parallax_u + i,
                parallax_v + i, scale + i,      shift + i};
    }
};

/// The rays of `count` pixels of a row, the first of column 0, `step` columns apart. Real-time
/// safe, like all here.
void find_view_rays(const ViewRow &row, float step, int count, const ViewRays &rays);

/// Points that are seen on tiles whose first corners' rays are in `rays`, and those of the corners
/// on the other end of their diagonals in `across`.
struct SeenOnTiles {
    ViewRays rays, across;
    const float *nearest, *farthest; ///< metres
    int count;
};
/// By how many of the view's pixels the nearest and the farthest point of each tile are displaced
/// against each other; where it has none it is anything.
void find_parallax(const SeenOnTiles &tiles, float *pixels);

/// Where corners are looked for.
struct CornerSearch {
    ImageView<const float> z; ///< as DepthSurface::z()
    const SurfacePieces &pieces;
    float nearest, farthest; ///< of what can be seen, metres
};

/// What is seen at corners of tiles, an array for each value, as of MappedCorner.
struct FoundCorners {
    float *u, *v;
    float *z; ///< 0: nothing is found, and the rest is anything
    float *scale, *shift;
};

/// Finds the points of a surface that are seen at some pixels of a view, by the depths that the
/// surface has there: from `first` on, metres, the place is looked up by the depth that the last
/// one has. It may be outside of the surface's picture. `first` is 0 where no point is to be found;
/// `millimetres`: that are read for each metre of depth in the view.
void find_corners(const CornerSearch &search, const ViewRays &rays, const float *first,
                  const float *millimetres, int count, const FoundCorners &corners);

} // namespace afterglow
