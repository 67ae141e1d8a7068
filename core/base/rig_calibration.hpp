// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/rigid_motion.hpp"

namespace afterglow {

/// Two cameras on one body: how each sees, and where the TOF camera is.
struct RigCalibration {
    CameraModel color;
    CameraModel tof;
    /// Takes points of the colour camera's frame to the TOF camera's, metres.
    Pose tof_from_color{};
    /// The TOF camera gives the distance along each pixel's ray, and not along Z.
    bool range_along_ray = false;
    /// By how much the time stamps of depth maps are too early on the images' clock, seconds.
    double tof_delay_s = 0;
    /// Time from reading the first row of an image to the last, seconds; 0 = global shutter.
    double readout_s = 0;

    bool operator==(const RigCalibration &) const = default;
};

} // namespace afterglow
