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
    rendering_->warp.run(surface, pose, rendering_->nothing, pool, {.motion = while_read});
    const ImageView<const WarpedPixel> warped = rendering_->warp.result();
    for (int v = 0; v < warped.height(); ++v) {
        const WarpedPixel *in = warped.row(v);
        std::uint16_t *out = rendering_->depth.row(v);
        for (int u = 0; u < warped.width(); ++u)
            out[u] = static_cast<std::uint16_t>(warped_z(in[u]) * 1000.0f + 0.5f);
    }
    return rendering_->depth;
}

} // namespace afterglow
