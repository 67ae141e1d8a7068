// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/camera_motion.hpp"
#include "core/alignment/pose_tracker.hpp"
#include "core/base/pyramid.hpp"
#include "core/base/worker_pool.hpp"
#include "core/calibration/self_calibration.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"
#include "core/warp/surface_registration.hpp"

#include <cstdint>

namespace afterglow {

/// Aligns each image with the keyframe of which most is in view. Where that fails, the image is
/// aligned with the one before it and the depth map composed for that, and the step is added to the
/// last pose (Noraky & Sze 2019 Eq. 8).
///
/// Allocates when made; the calls are real-time safe.
class KeyframeTracker {
public:
    KeyframeTracker(const KeyframeOptions &options, const Views &views, WorkerPool &pool);

    /// The next image. The one before it is kept.
    void load(LumaView luma);
    const Pyramid &image() const { return image_; }

    /// Aligns the image taken at `t_ns`, `dt` seconds after the one before, and advances `motion`.
    /// `previous_depth`: the map composed for the image before, empty where there is none;
    /// `correction`: the one it was composed with. There must be keyframes.
    void align(const KeyframeSet &keyframes, std::int64_t t_ns, double dt, DepthView previous_depth,
               const DepthCorrection &correction, CameraMotion &motion);
    /// The last image became a keyframe: it is known where it is.
    void keyframe_added() { last_good_covariance_.setZero(); }

    /// The keyframe that the last image was aligned with.
    int reference() const { return reference_; }
    /// Of the last image with the reference keyframe, whichever way it was found.
    const Alignment &alignment() const { return alignment_; }
    /// The last image was aligned with the one before it: brightness is relative to that.
    bool bridged() const { return bridged_; }
    /// The template that the image was compared with, and how: the reference keyframe's, or that of
    /// the image before.
    const AlignmentTemplate &compared(const KeyframeSet &keyframes) const;
    const Alignment &compared_alignment() const { return bridged_ ? step_ : alignment_; }

private:
    int pick_reference(const KeyframeSet &keyframes, const Pose &predicted) const;
    bool bridge(const Pose &reference_from_world, const Pose &predicted, double dt,
                DepthView previous_depth, const DepthCorrection &correction,
                const CameraMotion &motion);

    Views views_;
    WorkerPool &pool_;
    PoseTracker tracker_;
    float newest_bonus_;
    Pyramid image_;
    Pyramid previous_image_;
    DepthSurface composed_surface_; ///< of the map composed for the image before
    SurfaceRegistration previous_;  ///< the same in the tracking camera, to bridge
    AlignmentTemplate previous_template_;
    int reference_ = 0;
    std::int64_t aligned_ = -1; ///< when the keyframe was taken that alignment_ is with
    Alignment alignment_;
    Alignment step_; ///< of the last image with the one before, if `bridged_`
    bool bridged_ = false;
    Eigen::Matrix<float, 6, 6> last_good_covariance_ = Eigen::Matrix<float, 6, 6>::Zero();
};

} // namespace afterglow
