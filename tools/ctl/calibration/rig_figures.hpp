// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/calibration/rig_files.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// What a person knows a camera by.
struct CameraFigures {
    double horizontal_degrees; ///< field of view, across the middle of the picture
    double vertical_degrees;
    double lens_px; ///< how far the lens moves the corner that it moves most
};
/// `camera` has no problem_of().
CameraFigures figures_of(const CameraModel &camera);

/// How much of the TOF camera's picture, 0 to 1, the colour camera does not see when everything is
/// 1 m away.
double share_outside(const CameraModel &color, const CameraModel &tof, const Pose &tof_from_color);

/// Sentences about what is allowed, but seldom true.
std::vector<std::string> suspicions(const PartialRig &rig);

} // namespace afterglow
