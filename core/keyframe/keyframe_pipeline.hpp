// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/worker_pool.hpp"
#include "core/keyframe/depth_composer.hpp"
#include "core/keyframe/depth_refinement.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/keyframe/motion_mask.hpp"
#include "core/keyframe/pose_tracker.hpp"
#include "core/keyframe/self_calibration.hpp"
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

private:
    using Matrix6f = Eigen::Matrix<float, 6, 6>;

    int pick_reference(const Pose &predicted) const;
    PosePrior prior_of(const Pose &predicted, const Eigen::Vector3d &turning, double dt,
                       double age_s) const;
    void align(double dt);
    bool bridge(const Pose &predicted, double dt);
    Pose moved_in(double seconds) const;
    void publish(FrameSource source);
    DepthFit fit_to_reference(const DepthSurface &fresh);
    void calibrate(const DepthFit &fit, const Pose &start, const Matrix6f &information);
    float fresh_error(const DepthSurface &surface) const;

    Intrinsics camera_;
    KeyframeOptions options_;
    WorkerPool &pool_;
    PoseTracker tracker_;
    KeyframeSet keyframes_;
    Pyramid image_;
    Pyramid previous_image_;
    DepthSurface arriving_;
    Keyframe bridge_; ///< the last image with the depth map composed for it
    DepthComposer composer_;
    MotionMask motion_mask_;
    SelfCalibration self_calibration_;

    Alignment alignment_; ///< of the last image with the reference keyframe
    Alignment step_;      ///< of the last image with the one before, if `bridged_`
    bool bridged_ = false;
    Matrix6f spread_ = Matrix6f::Zero(); ///< covariance of alignment_, kept if it fails
    Pose now_;                           ///< world to camera when the last image was exposed
    Pose depth_now_;                     ///< and when its depth map was, or would have been
    Pose velocity_;                      ///< motion between the last two images
    double velocity_s_ = 0;
    Eigen::Vector3d turning_ = Eigen::Vector3d::Zero(); ///< rad/s
    std::int64_t t_ns_ = 0;
    std::int64_t measured_ns_ = 0;
    Pose measured_from_world_; ///< where the last measurement was made
    int reference_ = 0;
    float fresh_fill_ = 1; ///< share of the pixels that the last measured map has
    int enough_ = 0;       ///< pixels covered after which no more maps are added
    float fresh_mre_ = 0;  ///< expected of a fresh measurement, percent
    Estimate estimate_;
};

} // namespace afterglow
