// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rig_calibration.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace afterglow {

/// What a calibration may not say, whatever file says it.
struct CalibrationProblem {
    std::string_view key; ///< of the TOML format's table: "width", "fx", "distortion"
    std::string sentence; ///< "0 is not allowed (a number from 1 to 100000)"
};

/// The first problem of a camera. Its lens must show a ray at every pixel of a grid of 17 x 17 that
/// has the corners.
std::optional<CalibrationProblem> problem_of(const CameraModel &camera);
/// The first problem of what two cameras are to each other: translation, delay, read-out time, and
/// a rotation after which they do not see the same.
std::optional<CalibrationProblem> problem_of(const RigCalibration &rig);

/// The rotation nearest to R, which is R itself where it is one to rounding. Nothing if R differs
/// from every rotation: R R^T by more than 1e-3 from the identity, or a mirror.
std::optional<Eigen::Matrix3d> exact_rotation(const Eigen::Matrix3d &R);

} // namespace afterglow
