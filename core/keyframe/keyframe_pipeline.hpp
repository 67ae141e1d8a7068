// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/worker_pool.hpp"
#include "core/keyframe/camera_motion.hpp"
#include "core/keyframe/depth_publication.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/keyframe/keyframe_tracker.hpp"
#include "core/keyframe/map_registration.hpp"
#include "core/pipeline.hpp"

#include <cstdint>

namespace afterglow {

/// Preset "default": each image is aligned directly with the image of a measured depth map, several
/// measured maps are warped into it, and the error of the result is predicted (docs/estimation.md).
///
/// The world's coordinates are those of the first measured frame. Real-time safe after
/// construction.
class KeyframePipeline final : public Pipeline {
public:
    KeyframePipeline(const KeyframeOptions &options, const Intrinsics &camera, WorkerPool &pool);

    const Estimate &track(LumaView luma, std::int64_t t_ns) override;
    const Estimate &measure(DepthView depth) override;
    void restart() override { keyframes_.clear(); }

private:
    /// Motion from an image's exposure to its depth map's.
    Pose lag() const { return motion_.moved_in(registration_.correction().lag_s); }
    void register_map();
    void forget();

    Intrinsics camera_;
    WorkerPool &pool_;
    KeyframeSet keyframes_;
    CameraMotion motion_; ///< when the last image was exposed
    Pose depth_now_;      ///< world to camera when its depth map was, or would have been
    KeyframeTracker tracker_;
    DepthSurface arriving_;
    MapRegistration registration_;
    DepthPublication publication_;
    std::int64_t t_ns_ = 0;
};

} // namespace afterglow
