// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/surface_registration.hpp"

#include "core/keyframe/views.hpp"

#include <cassert>

namespace afterglow {

SurfaceRegistration::SurfaceRegistration(const Intrinsics &from, const Intrinsics &to,
                                         const Pose &pose, const KeyframeOptions &options)
    : pose_(pose) {
    if (!(from == to && is_identity(pose)))
        rendering_ = std::make_unique<Rendering>(from, to, options);
}

const DepthSurface &SurfaceRegistration::seen(const DepthSurface &surface, WorkerPool &pool,
                                              const Pose &motion, const Twist &while_read) {
    if (!rendering_)
        return surface;
    rendering_->surface.build(rendered(surface, motion * pose_, pool, while_read), pool);
    return rendering_->surface;
}

DepthView SurfaceRegistration::rendered(const DepthSurface &surface, const Pose &pose,
                                        WorkerPool &pool, const Twist &while_read) {
    assert(rendering_);
    rendering_->warp.run(surface, pose, pool, rendering_->depth, rendering_->edge_distance, {},
                         {.motion = while_read});
    return rendering_->depth;
}

} // namespace afterglow
