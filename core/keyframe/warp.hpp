// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/worker_pool.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/open_tiles.hpp"

#include <algorithm>
#include <cstdint>

namespace afterglow {

struct WarpOptions {
    /// Readings nearer than this to a depth edge of their map are not carried, pixels (1 = all).
    int least_edge_distance_px = 2;
    /// Such readings hide what is behind them all the same, as near as the nearest of their
    /// neighbours. Between two cameras side by side the far surface would show through all edges of
    /// the near one, on one side.
    bool edges_hide = false;
    /// Widest crack that is filled, pixels: 0, 1 or 2.
    int crack_px = 2;
};

/// One pixel of a warped map; 0 = nothing. The high 19 bits below the sign are the depth in 1/16
/// mm, so that integer order is depth order; under them a mark for filled cracks and the edge
/// distance.
using WarpedPixel = std::int32_t;
constexpr float warped_units_per_m = 16000.0f;
constexpr int warped_depth_shift = 12;
/// The most that sensor.farthest_m may be: with the move to the pixel's centre it must fit 19 bits.
constexpr float warped_farthest_m = 30.0f;
constexpr WarpedPixel warped_crack = 1 << 3;
constexpr WarpedPixel warped_edge_mask = 7;
/// A pixel of the scattered map on which no point has landed.
constexpr WarpedPixel nothing_landed = 0x7fffffff;

inline float warped_z(WarpedPixel p) {
    return static_cast<float>(p >> warped_depth_shift) * (1.0f / warped_units_per_m);
}

/// What rows that are read one after the other do to a warp.
struct RollingShutter {
    /// The rows of the surface turn against those of the view, as of Placement::skew, radians.
    Eigen::Vector3f skew = Eigen::Vector3f::Zero();
    /// Motion (v, w) of the scene, the view's frame, while the view is read from the first row to
    /// the last; the pose is that of its middle row. For a surface that was measured all at once.
    Twist motion = Twist::Zero();
};

/// Forward reprojection of a measured surface (Noraky & Sze 2019 Eq. 9 of the reprojection
/// section): each point lands on the pixel nearest to its projection, its depth moved to that
/// pixel's centre along the surface's own slope; of several, the nearest wins. The minimum does not
/// depend on order, so the result is the same whatever the number of workers.
///
/// Allocates when made; the calls are real-time safe.
class Warp {
public:
    /// Surfaces of the camera `from` are carried into the view of the camera `to`.
    Warp(const Intrinsics &from, const Intrinsics &to, const WarpOptions &options);

    /// Carries `surface` along `pose` (its camera's frame to the other's) and fills cracks: empty
    /// pixels with the same surface on two opposite sides, and pixels of a far surface that show
    /// through a near one. What was hidden or outside the picture stays empty. Only for the pixels
    /// that are empty in `taken`; what result() has elsewhere, or outside of open() tiles, means
    /// nothing.
    void run(const DepthSurface &surface, const Pose &pose, DepthView taken, WorkerPool &pool,
             const RollingShutter &shutter = {});

    ImageView<const WarpedPixel> result() const { return filled_; }
    /// Tiles in which pixels were empty.
    const OpenTiles &open() const { return open_; }

private:
    int margin() const { return std::max(options_.crack_px, 1); }
    ImageView<const WarpedPixel> landed() const;
    bool may_land(const DepthSurface &surface, int tile_x, int tile_y, const Pose &pose,
                  double margin_px) const;
    void scatter(const DepthSurface &surface, const Pose &pose, const RollingShutter &shutter,
                 int first_tile_row, int end_tile_row, bool alone);
    void fill_cracks(const DepthSurface &surface, DepthView taken, int v, int begin, int end);
    WarpedPixel fill_pixel(const DepthSurface &surface, const WarpedPixel *at) const;

    Intrinsics from_, to_;
    WarpOptions options_;
    OpenTiles open_;
    Image<WarpedPixel> nearest_; ///< with a margin on all sides, on which nothing lands
    Image<WarpedPixel> filled_;
    Image<std::uint8_t> doubtful_; ///< pixels that may be cracks
    Image<std::uint8_t> landing_;  ///< tiles of the surface that may land where there is room
};

} // namespace afterglow
