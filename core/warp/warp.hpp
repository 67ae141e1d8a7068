// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/worker_pool.hpp"
#include "core/base/worker_shares.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/block_grid.hpp"
#include "core/warp/surface_projection.hpp"
#include "core/warp/tile_mapping.hpp"
#include "core/warp/warp_kernels.hpp"

#include <cstdint>

namespace afterglow {

struct WarpOptions {
    /// Readings nearer than this to a depth edge of their map are not carried, pixels (1 = all).
    int least_edge_distance_px = 2;
    /// Such readings hide what is behind them all the same, as near as the nearest of their
    /// neighbours. Between two cameras side by side the far surface would show through all edges of
    /// the near one, on one side.
    bool edges_hide = false;
};

/// Draws a measured surface as another view shows it.
///
/// On mapped tiles of the view each pixel looks up its point on the surface (TileMapping). On
/// others, at the border of the view, or if `edges_hide` where points hide others, they are
/// reprojected forwards (Noraky & Sze 2019, Eq. 7): each lands on the
/// pixel nearest to its projection, its depth moved to that pixel's centre along the surface's own
/// slope; of several, the nearest wins. The minimum does not depend on order, so the result is the
/// same whatever the number of workers.
///
/// Allocates when made; the calls are real-time safe.
class Warp {
public:
    /// Surfaces of the camera `from` are carried into the view of the camera `to`.
    Warp(const Intrinsics &from, const Intrinsics &to, const WarpOptions &options,
         WorkerPool &pool);

    /// Carries `surface` along `pose` (its camera's frame to the other's) and fills cracks: empty
    /// pixels with the same surface on two opposite sides, and pixels of a far surface that show
    /// through a near one. What was hidden or outside the picture stays empty.
    ///
    /// `depth` and `edge_distance` are of the view's size and become, both 0 where there is
    /// nothing: what a TOF camera with that `correction` would read, millimetres; and how far its
    /// point is from the next edge of the surface, pixels, at most far_from_edge.
    /// Returns how many pixels have depth.
    int run(const DepthSurface &surface, const Pose &pose, ImageView<std::uint16_t> depth,
            ImageView<std::uint8_t> edge_distance, const DepthCorrection &correction = {},
            const RollingShutter &shutter = {});

    /// Bounds of what the last run() has drawn, by tile of the view.
    const Image<TileReadings> &readings() const { return readings_; }

private:
    /// As far as cracks are looked across.
    static constexpr int margin = widest_crack_px;
    ImageView<const WarpedPixel> landed() const;
    void scatter(const DepthSurface &surface, const SurfaceProjection &projection);
    void scatter_rows(const DepthSurface &surface, const SurfaceProjection &projection,
                      int first_row, int end_row, Image<WarpedPixel> &nearest) const;
    /// Where and how to draw.
    struct Drawing {
        const DepthSurface &surface;
        const DepthCorrection &correction;
        ImageView<std::uint16_t> depth;
        ImageView<std::uint8_t> edge_distance;
    };
    void look_up_nodes(const DepthSurface &surface, int tile_row);
    int draw_tiles(const Drawing &to, int tile_row);
    int draw_mixed(const Drawing &to, int v, int begin, int end) const;
    WarpedPixel fill_pixel(const DepthSurface &surface, const WarpedPixel *at) const;

    Intrinsics from_, to_;
    WarpOptions options_;
    WorkerPool &pool_;
    TileMapping tiles_;
    BlockGrid grid_; ///< of the mapped ones
    Image<TileReadings> readings_;
    /// What landed: maps with a margin on all sides on which nothing lands; in the end all is in
    /// the first.
    WorkerShares<Image<WarpedPixel>> nearest_;
};

} // namespace afterglow
