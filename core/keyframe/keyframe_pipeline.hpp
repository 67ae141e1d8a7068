// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/camera_motion.hpp"
#include "core/base/worker_pool.hpp"
#include "core/calibration/calibration_guard.hpp"
#include "core/keyframe/depth_publication.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/keyframe/keyframe_tracker.hpp"
#include "core/keyframe/map_registration.hpp"
#include "core/pipeline.hpp"

#include <cstdint>
#include <memory>

namespace afterglow {

/// Preset "default": each image is aligned directly with the image of a measured depth map, several
/// measured maps are warped into it, and the error of the result is predicted (docs/estimation.md).
///
/// The world's coordinates are those of the tracking camera at the first measured frame. Real-time
/// safe after construction.
class KeyframePipeline final : public Pipeline {
public:
    KeyframePipeline(const KeyframeOptions &options, const Views &views, WorkerPool &pool);

    const Estimate &track(LumaView luma, std::int64_t t_ns) override;
    const Estimate &measure(const Measurement &measurement) override;
    void expect_lag(double lag_s) override { expected_lag_s_ = lag_s; }
    void prepare() override;
    void restart() override {
        keyframes_.clear();
        motion_.restart();
    }
    void want_confidence(bool wanted) override { publication_.want_confidence(wanted); }
    void want_depth(bool wanted) override { depth_wanted_ = wanted; }

private:
    /// Motion of the tracking camera from an image's exposure to its depth map's.
    Pose lag() const { return motion_.moved_in(stated_lag_s_ + registration_.correction().lag_s); }
    /// Motion of the scene before the tracking camera while its last image was read.
    Twist while_read() const { return views_.readout_s * motion_.rate(); }
    /// World to published camera at the last image.
    Pose published_now() const;
    /// The correction that composed maps are shown with.
    DepthCorrection published_correction() const;
    bool warps_arriving() const;
    const Estimate &draw();
    std::optional<MapComparison> register_map();
    void forget();

    Views views_;
    WorkerPool &pool_;
    KeyframeSet keyframes_;
    CameraMotion motion_;       ///< of the tracking camera, when the last image was exposed
    double stated_lag_s_ = 0;   ///< of the last image's depth map
    double expected_lag_s_ = 0; ///< of the next one's
    Pose depth_now_; ///< world to surface camera when its depth map was, or would have been
    KeyframeTracker tracker_;
    DepthSurface arriving_;
    MapRegistration registration_;
    /// Null: a device has registered the depth, and its calibration is its own.
    std::unique_ptr<CalibrationGuard> guard_;
    SurfaceRegistration seen_;      ///< measured surfaces as the tracking camera sees them
    SurfaceRegistration published_; ///< and the published one
    DepthPublication publication_;
    std::int64_t t_ns_ = 0;
    bool depth_wanted_ = true;
    bool prepared_ = true; ///< the newest keyframe, for later images
};

} // namespace afterglow
