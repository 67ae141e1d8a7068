// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/worker_pool.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/warp.hpp"

#include <memory>

namespace afterglow {

/// Renders the surfaces that one camera measured as another one sees them. What is hidden from that
/// camera is not there, and what it alone sees is a hole.
///
/// Allocates when made; run() is real-time safe.
class SurfaceRendering {
public:
    SurfaceRendering(const Intrinsics &from, const Intrinsics &to, const WarpOptions &options,
                     WorkerPool &pool);

    /// Depth, millimetres, 0 = none, unfiltered, valid until the next call. `pose` takes points of
    /// the surface's frame to the other camera's, and need not be rigid. `while_read`:
    /// RollingShutter::motion.
    DepthView run(const DepthSurface &surface, const Pose &pose,
                  const Twist &while_read = Twist::Zero());

private:
    Warp warp_;
    DepthMap depth_;
    Image<std::uint8_t> edge_distance_; ///< is not used
};

/// Shows the surfaces that one camera measured as another camera of the same body sees them.
///
/// Allocates when made; the calls are real-time safe.
class SurfaceRegistration {
public:
    /// `pose` takes points of the frame of `from` to that of `to`.
    SurfaceRegistration(const Intrinsics &from, const Intrinsics &to, const Pose &pose,
                        const SurfaceOptions &surface, const WarpOptions &warp, WorkerPool &pool);

    /// `surface` itself, where both cameras are one; else another one, valid until the next call.
    /// `motion`: of the camera `to` from when the surface was measured to when it is seen.
    /// `while_read`: RollingShutter::motion.
    const DepthSurface &seen(const DepthSurface &surface, const Pose &motion = {},
                             const Twist &while_read = Twist::Zero());
    /// SurfaceRendering::run(), where both cameras are not one.
    DepthView rendered(const DepthSurface &surface, const Pose &pose,
                       const Twist &while_read = Twist::Zero());

private:
    struct Seen {
        Seen(const Intrinsics &from, const Intrinsics &to, const SurfaceOptions &surface_options,
             const WarpOptions &warp_options, WorkerPool &pool)
            : rendering(from, to, warp_options, pool), surface(to, surface_options) {}

        SurfaceRendering rendering;
        DepthSurface surface;
    };

    Pose pose_;
    WorkerPool &pool_;
    std::unique_ptr<Seen> seen_; ///< null: both cameras are one
};

} // namespace afterglow
