// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rig_calibration.hpp"

namespace afterglow::testing {

/// A wide colour camera with a rolling shutter, and a small TOF camera 3 cm beside it.
inline RigCalibration test_rig() {
    return {.color = {.pinhole = {80, 81, 63.5, 47.5, 128, 96},
                      .lens = Lens::kannala_brandt,
                      .distortion = {-0.02, 0.003, -0.001, 0.0002}},
            .tof = {.pinhole = {60, 60, 31.5, 23.5, 64, 48},
                    .lens = Lens::brown_conrady,
                    .distortion = {-0.1, 0.02, 0.001, -0.0008}},
            .tof_from_color = {Eigen::Matrix3d::Identity(), {-0.03, 0.002, 0.001}},
            .tof_delay_s = 0.004,
            .readout_s = 0.02};
}

} // namespace afterglow::testing
