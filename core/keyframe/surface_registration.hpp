// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/worker_pool.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/keyframe/warp.hpp"

#include <Eigen/Core>

#include <memory>

namespace afterglow {

/// Shows the surfaces that one camera measured as another camera of the same body sees them. What
/// is hidden from that camera is not there, and what it alone sees is a hole.
///
/// Allocates when made; the calls are real-time safe.
class SurfaceRegistration {
public:
    /// `pose` takes points of the frame of `from` to that of `to`.
    SurfaceRegistration(const Intrinsics &from, const Intrinsics &to, const Pose &pose,
                        const KeyframeOptions &options);

    /// `surface` itself, where both cameras are one; else another one, valid until the next call.
    /// `motion`: of the camera `to` from when the surface was measured to when it is seen.
    /// `while_read`: RollingShutter::motion.
    const DepthSurface &seen(const DepthSurface &surface, WorkerPool &pool, const Pose &motion = {},
                             const Twist &while_read = Twist::Zero());
    /// The same as depth, millimetres, 0 = none, unfiltered; `pose` takes points of the surface's
    /// frame to the other camera's. Valid until the next call.
    DepthView rendered(const DepthSurface &surface, const Pose &pose, WorkerPool &pool,
                       const Twist &while_read = Twist::Zero());

private:
    struct Rendering {
        Rendering(const Intrinsics &from, const Intrinsics &to, const KeyframeOptions &options)
            : warp(from, to, options.warp), depth(to.width, to.height),
              edge_distance(to.width, to.height), surface(to, options.surface) {}

        Warp warp;
        DepthMap depth;
        Image<std::uint8_t> edge_distance; ///< not used
        DepthSurface surface;
    };

    Pose pose_;
    std::unique_ptr<Rendering> rendering_; ///< null: both cameras are one
};

} // namespace afterglow
