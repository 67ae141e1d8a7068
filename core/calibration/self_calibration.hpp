// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/surface/depth_correction.hpp"

#include <Eigen/Core>

namespace afterglow {

/// One sigma of each unknown before anything is known of it; 0: taken to be 0, not learnt.
struct SelfCalibrationOptions {
    float tilt = 0.03f;      ///< radians, between the TOF camera's and the colour camera's axes
    float curvature = 0.03f; ///< share of the depth at 45 degrees off the axis
    float lag_s = 0.01f;     ///< seconds between the exposures of an image and its depth map
    /// Systematic error of what one pair of maps tells of tilt and curvature, in those sigmas.
    float pair_error = 2.0f;
    /// The same of the lag. Pairs share less of it: they were taken at other motions.
    float lag_pair_error = 1.0f;
};

/// What one pair of maps tells of the unknowns (shape, lag): normal equations H p = g.
struct CalibrationEvidence {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
};

/// Learns the calibration from pairs of measured maps: linear least squares over all so far, with
/// priors. Real-time safe.
class SelfCalibration {
public:
    explicit SelfCalibration(const SelfCalibrationOptions &options);

    /// Evidence that is not finite is left out.
    void add(const CalibrationEvidence &evidence);
    const DepthCorrection &correction() const { return correction_; }

private:
    Eigen::Vector4d sigma_;         ///< of the prior
    Eigen::Vector4d pair_variance_; ///< in units of the prior's variances
    CalibrationEvidence sum_;       ///< in units of the prior's sigmas
    DepthCorrection correction_;
};

} // namespace afterglow
