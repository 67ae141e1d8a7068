// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"

#include <string>
#include <string_view>

namespace afterglow {

/// Reads the calibration of a rig, a TOML file (docs/calibration.md explains each key). The error's
/// message has one line for each problem: `file:line: key: what is wrong (what is expected)`. The
/// rotation is made orthonormal, and the problems of config/calibration_limits.hpp are refused.
Result<RigCalibration> load_calibration(const std::string &path);

/// The same of a file's text; `path` stands in messages.
Result<RigCalibration> parse_calibration(std::string_view text, const std::string &path);

/// That of a recording of two cameras, FOLDER/calibration.toml; "" where the folder has none: its
/// depth is registered to the images.
std::string calibration_of_recording(const std::string &folder);

/// The file that says this.
std::string calibration_toml(const RigCalibration &rig);

/// What the file calls it.
std::string_view lens_name(Lens lens);

} // namespace afterglow
