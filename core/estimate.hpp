// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/calibration_state.hpp"

#include <cstdint>

namespace afterglow {

/// Where a published depth map comes from.
enum class FrameSource : std::uint8_t {
    none = 0,      ///< no depth could be given: the map is all zeros
    measured = 1,  ///< by the TOF camera, for this image
    estimated = 2, ///< by warping an earlier measurement to this image
};

/// The confidence plane: 0 = no depth; 255 = measured in this frame; 1 to 254 = estimated, with an
/// expected relative error of (255 - c) * confidence_step.
constexpr std::uint8_t no_confidence = 0;
constexpr std::uint8_t measured_confidence = 255;
/// Estimated, by a pipeline that does not predict its error, or with an error of 12.7 % or more.
constexpr std::uint8_t unknown_confidence = 1;
constexpr float confidence_step = 0.0005f;
/// `relative_error`: share of the depth.
inline std::uint8_t estimated_confidence(float relative_error) {
    const float c = 255.0f - relative_error * (1.0f / confidence_step);
    return static_cast<std::uint8_t>(c < 1.0f ? 1.0f : (c > 254.0f ? 254.0f : c));
}
/// The expected relative error that a confidence stands for.
inline float expected_error(std::uint8_t confidence) {
    return static_cast<float>(measured_confidence - confidence) * confidence_step;
}

/// A depth map for one image, and what is known of it.
struct Estimate {
    FrameSource source = FrameSource::none;
    /// Images since the measurement this map rests on; 0 for a measured map.
    std::uint32_t age_frames = 0;
    std::int64_t age_ns = 0;
    /// Takes points of the last measured map's camera frame to this image's.
    Pose pose{};
    /// Takes points of this image's camera frame to the world's, which lasts as long as the camera
    /// is tracked: its origin is the camera of the first measurement.
    Pose world_from_camera{};
    /// Counts worlds: another number, another origin. 0: there is none yet.
    std::uint32_t world = 0;
    /// Both poses are of this image, not of an earlier one.
    bool tracked = false;
    /// Predicted mean relative error against a reading of the TOF camera, percent. Negative: this
    /// preset does not predict it.
    float expected_mre = -1;
    /// The same, if the errors of near views were not correlated (uncorrelated_share()): only what
    /// carrying the map adds makes it grow. Holds where expected_mre does, and so does what
    /// follows.
    float independent_mre = -1;
    /// independent_mre of a fresh measurement, as far as the last one tells.
    float fresh_mre = 0;
    /// What the gate adds to expected_mre for pixels that have no depth because something moved
    /// there, percent.
    float moved_mre = 0;
    /// Percent of the pixels that have depth.
    float coverage = 0;
    /// Percent of the pixels that a fresh measurement would cover, as far as the last one tells.
    float relative_coverage = 100;
    /// Matches that agree with the pose, of `matches` tried; 0 where no pose was estimated.
    int inliers = 0;
    int matches = 0;
    /// What the measurements so far say of the cameras' calibration.
    CalibrationState calibration{};
    /// There is no telling what the scene's depth is: only a measurement helps.
    bool wants_measurement = false;
    /// Millimetres; valid until the estimator's next call. Empty where nobody wants it
    /// (Pipeline::want_depth()): expected errors and coverage are then those of the last map.
    DepthView depth{};
    /// Of each pixel of `depth`: no_confidence, measured_confidence, or for estimated depth the
    /// expected relative error (estimated_confidence(), unknown_confidence). Empty where nobody
    /// wants it (Pipeline::want_confidence()).
    ImageView<const std::uint8_t> confidence{};
};

} // namespace afterglow
