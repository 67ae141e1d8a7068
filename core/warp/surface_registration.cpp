// SPDX-License-Identifier: Apache-2.0
#include "core/warp/surface_registration.hpp"

#include "core/base/views.hpp"

#include <cassert>

namespace afterglow {

SurfaceRendering::SurfaceRendering(const Intrinsics &from, const Intrinsics &to,
                                   const WarpOptions &options, WorkerPool &pool)
    : warp_(from, to, options, pool), depth_(to.width, to.height),
      edge_distance_(to.width, to.height) {}

DepthView SurfaceRendering::run(const DepthSurface &surface, const Pose &pose,
                                const Twist &while_read) {
    warp_.run(surface, pose, depth_, edge_distance_, {}, {.motion = while_read});
    return depth_;
}

SurfaceRegistration::SurfaceRegistration(const Intrinsics &from, const Intrinsics &to,
                                         const Pose &pose, const SurfaceOptions &surface,
                                         const WarpOptions &warp, WorkerPool &pool)
    : pose_(pose), pool_(pool) {
    if (!(from == to && is_identity(pose)))
        seen_ = std::make_unique<Seen>(from, to, surface, warp, pool);
}

const DepthSurface &SurfaceRegistration::seen(const DepthSurface &surface, const Pose &motion,
                                              const Twist &while_read) {
    if (!seen_)
        return surface;
    seen_->surface.build(seen_->rendering.run(surface, motion * pose_, while_read), pool_);
    return seen_->surface;
}

DepthView SurfaceRegistration::rendered(const DepthSurface &surface, const Pose &pose,
                                        const Twist &while_read) {
    assert(seen_);
    return seen_->rendering.run(surface, pose, while_read);
}

} // namespace afterglow
