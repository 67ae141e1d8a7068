// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"
#include "core/calibration/depth_refinement.hpp"
#include "core/calibration/self_calibration.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/keyframe/keyframe_options.hpp"

namespace afterglow {

/// Places new measured maps among the earlier ones and learns from each pair how the TOF camera
/// differs from a pinhole camera exposed with the images. Real-time safe.
class MapRegistration {
public:
    MapRegistration(const KeyframeOptions &options, const Views &views)
        : camera_(views.surface), surface_from_tracking_(views.surface_from_tracking),
          self_calibration_(options.self_calibration) {}

    /// Fits `fresh`, expected at `expected` (world to surface camera), to `reference` by geometry
    /// and by what the images told, and learns from the two if both agree. `alignment`: of the
    /// image of `fresh` with `reference`; `rate`: CameraMotion::rate().
    DepthFit add(const Keyframe &reference, const DepthSurface &fresh, const Pose &expected,
                 const Alignment &alignment, const Twist &rate);

    /// What has been learnt.
    const DepthCorrection &correction() const { return self_calibration_.correction(); }

private:
    Intrinsics camera_;
    Pose surface_from_tracking_;
    SelfCalibration self_calibration_;
};

} // namespace afterglow
