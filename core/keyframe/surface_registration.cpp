// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_registration.hpp"

#include "core/keyframe/views.hpp"

#include <cassert>

namespace afterglow {

SurfaceRendering::SurfaceRendering(const Intrinsics &from, const Intrinsics &to,
                                   const KeyframeOptions &options)
    : warp_(from, to, options.warp), depth_(to.width, to.height),
      edge_distance_(to.width, to.height) {}

DepthView SurfaceRendering::run(const DepthSurface &surface, const Pose &pose, WorkerPool &pool,
                                const Twist &while_read) {
    warp_.run(surface, pose, pool, depth_, edge_distance_, {}, {.motion = while_read});
    return depth_;
}

SurfaceRegistration::SurfaceRegistration(const Intrinsics &from, const Intrinsics &to,
                                         const Pose &pose, const KeyframeOptions &options)
    : pose_(pose) {
    if (!(from == to && is_identity(pose)))
        seen_ = std::make_unique<Seen>(from, to, options);
}

const DepthSurface &SurfaceRegistration::seen(const DepthSurface &surface, WorkerPool &pool,
                                              const Pose &motion, const Twist &while_read) {
    if (!seen_)
        return surface;
    seen_->surface.build(seen_->rendering.run(surface, motion * pose_, pool, while_read), pool);
    return seen_->surface;
}

DepthView SurfaceRegistration::rendered(const DepthSurface &surface, const Pose &pose,
                                        WorkerPool &pool, const Twist &while_read) {
    assert(seen_);
    return seen_->rendering.run(surface, pose, pool, while_read);
}

} // namespace afterglow
