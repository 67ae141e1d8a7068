// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/calibration_file.hpp"
#include "drivers/files/recording.hpp"

#include <optional>
#include <string>

namespace afterglow::vm {

/// A recording that cameras play: with its calibration it is of two.
inline Result<Recording> open_played(const std::string &folder) {
    const std::string file = calibration_of_recording(folder);
    if (file.empty())
        return open_recording(folder);
    const Result<RigCalibration> rig = load_calibration(file);
    if (!rig)
        return rig.error();
    return open_recording(folder, std::nullopt, *rig);
}

} // namespace afterglow::vm
