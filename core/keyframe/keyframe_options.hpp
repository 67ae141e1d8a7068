// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/alignment_template.hpp"
#include "core/alignment/camera_motion.hpp"
#include "core/alignment/direct_alignment.hpp"
#include "core/calibration/self_calibration.hpp"
#include "core/error/expected_error.hpp"
#include "core/surface/depth_surface.hpp"
#include "core/warp/warp.hpp"

namespace afterglow {

/// How several keyframes make one depth map.
struct ComposeOptions {
    int keyframes = 6;      ///< measured maps that are kept
    int maps_per_frame = 1; ///< most maps warped into one frame
    /// An earlier keyframe is tracked against only if that much more of it is in view, percent.
    float newest_bonus = 25;
    bool follow_moving = true; ///< depth goes along with what moves by itself
};

/// The stages of preset "default" (docs/estimation.md).
struct KeyframeOptions {
    MotionOptions motion;
    SelfCalibrationOptions self_calibration;
    SurfaceOptions surface;
    TemplateOptions alignment_template;
    AlignmentOptions alignment;
    WarpOptions warp;
    ComposeOptions compose;
    ErrorOptions error;
    /// A calibration (Views::calibrated) that is found to be wrong is corrected.
    bool correct_calibration = true;
};

} // namespace afterglow
