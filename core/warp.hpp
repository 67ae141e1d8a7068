// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/camera.hpp"
#include "core/depth_surface.hpp"
#include "core/pose.hpp"
#include "core/worker_pool.hpp"

namespace afterglow {

struct WarpOptions {
    /// Readings nearer than this to a depth edge of their map are not carried, pixels (1 = all).
    int least_edge_distance_px = 2;
    /// Widest crack that is filled, pixels.
    int crack_px = 2;
};

/// One pixel of a warped map: depth in units of 1/8 mm... see WarpedMap. 0 = nothing.
/// High 20 bits: depth in 1/16 mm, so that integer order is depth order. Low bits: edge distance
/// (3 bits) and a mark for filled cracks.
using WarpedPixel = std::uint32_t;
constexpr float warped_units_per_m = 16000.0f;
constexpr int warped_depth_shift = 12;
constexpr WarpedPixel warped_crack = 1u << 3;
constexpr WarpedPixel warped_edge_mask = 7u;

inline float warped_z(WarpedPixel p) {
    return static_cast<float>(p >> warped_depth_shift) * (1.0f / warped_units_per_m);
}

/// Forward reprojection of a measured surface (seed paper Eq. 9 of the reprojection section):
/// each point lands on the pixel nearest to its projection, its depth moved to that pixel's centre
/// along the surface's own slope; of several, the nearest wins. The minimum does not depend on
/// order, so the result is the same whatever the number of workers.
///
/// Allocates when made; run() is real-time safe.
class Warp {
public:
    Warp(const Intrinsics &camera, const WarpOptions &options);

    /// Carries `surface` along `pose` and fills cracks: empty pixels with the same surface on two
    /// opposite sides. What was hidden or outside the picture stays empty.
    /// `skew`: rolling shutter, see Alignment::skew.
    void run(const DepthSurface &surface, const Pose &pose, WorkerPool &pool,
             const Eigen::Vector3f &skew = Eigen::Vector3f::Zero());

    ImageView<const WarpedPixel> result() const { return filled_; }

private:
    void scatter(const DepthSurface &surface, const Pose &pose, const Eigen::Vector3f &skew,
                 int first_row, int end_row, bool alone);
    void fill_cracks(const DepthSurface &surface, int first_row, int end_row);

    Intrinsics camera_;
    WarpOptions options_;
    Image<WarpedPixel> nearest_;
    Image<WarpedPixel> filled_;
};

} // namespace afterglow
