// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/alignment_template.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/keyframe/direct_alignment.hpp"
#include "core/keyframe/expected_error.hpp"
#include "core/keyframe/self_calibration.hpp"
#include "core/keyframe/warp.hpp"

namespace afterglow {

/// How a held camera moves (one sigma).
struct MotionOptions {
    float speed = 0.2f;                 ///< m/s
    float angular_acceleration = 15.0f; ///< rad/s^2
    /// Longest time from the first to the last row of a picture being read; 0 = global shutter.
    float readout_s = 0.02f;
};

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
};

} // namespace afterglow
