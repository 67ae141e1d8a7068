// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/camera.hpp"
#include "core/depth_composer.hpp"
#include "core/depth_refinement.hpp"
#include "core/estimate.hpp"
#include "core/keyframe.hpp"
#include "core/keyframe_options.hpp"
#include "core/motion_mask.hpp"
#include "core/pose_tracker.hpp"
#include "core/pyramid.hpp"
#include "core/worker_pool.hpp"

#include <cstdint>

namespace afterglow {

/// Preset "default": each image is aligned directly with the image of a measured depth map, several
/// measured maps are warped into it, and the error of the result is predicted (docs/estimation.md).
///
/// The world's coordinates are those of the first measured frame. track() and measure() as
/// Estimator's: they allocate nothing.
class KeyframePipeline {
public:
    KeyframePipeline(const KeyframeOptions &options, const Intrinsics &camera, WorkerPool &pool);

    const Estimate &track(LumaView luma, std::int64_t t_ns);
    const Estimate &measure(DepthView depth);

private:
    int pick_reference(const Pose &predicted) const;
    void align(double dt);
    void publish(FrameSource source);
    DepthFit fit_to_reference(const DepthSurface &fresh) const;
    float fresh_error(const DepthSurface &surface) const;

    Intrinsics camera_;
    KeyframeOptions options_;
    WorkerPool &pool_;
    PoseTracker tracker_;
    KeyframeSet keyframes_;
    Pyramid image_;
    DepthSurface arriving_;
    DepthComposer composer_;
    MotionMask motion_mask_;
    Alignment alignment_;

    Pose now_;      ///< world to camera at the last image
    Pose velocity_; ///< motion between the last two images
    double velocity_s_ = 0;
    Eigen::Vector3d turning_ = Eigen::Vector3d::Zero(); ///< rad/s
    std::int64_t t_ns_ = 0;
    std::int64_t measured_ns_ = 0;
    Pose measured_from_world_; ///< where the last measurement was made
    int reference_ = 0;
    float fresh_fill_ = 1; ///< share of the pixels that the last measured map has
    float fresh_mre_ = 0;  ///< expected of a fresh measurement, percent
    Estimate estimate_;
};

} // namespace afterglow
