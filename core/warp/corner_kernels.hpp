// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/surface/surface_pieces.hpp"

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

/// A row of tiles: the rays of their corners at the left above and at the right below, and the
/// depths of what is seen on them.
struct SeenOnTiles {
    ViewRays left_above, right_below;
    const float *nearest, *farthest; ///< metres
    int count;
};
/// By how many of the view's pixels the nearest and the farthest point of each tile are displaced
/// against each other. Where nothing is seen on a tile the value is not defined.
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
    float *z; ///< 0: nothing is found, and the other values are not defined
    float *scale, *shift;
};

/// Finds the points of a surface that are seen at some pixels of a view. The search begins with the
/// depth `first`, metres: the surface's depth at the place that this depth gives is the next depth,
/// until the place moves by less than 0.03 pixels, or three times. Places may be outside of the
/// surface's picture. `first` is 0 for pixels that are left out. `millimetres`: readings for each
/// metre of depth in the view.
void find_corners(const CornerSearch &search, const ViewRays &rays, const float *first,
                  const float *millimetres, int count, const FoundCorners &corners);

} // namespace afterglow
