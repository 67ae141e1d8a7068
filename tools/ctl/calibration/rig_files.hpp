// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/calibration/found_calibration.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// Files that together describe a rig, and what they do not say.
struct RigFiles {
    std::vector<std::string> paths;
    CalibrationHints hints;
    /// Which camera it is: its name in a file, or the path of a file that has one. Empty: the first
    /// one that is left.
    std::string color, tof;
    /// WIDTHxHEIGHT, where the file does not tell. Empty: it must.
    std::string color_size, tof_size;
    bool invert =
        false; ///< translation and rotation take points of the TOF camera to the colour one
};

/// What is known of a rig.
struct PartialRig {
    std::optional<FoundCamera> color, tof; ///< one at least
    std::optional<Pose> tof_from_color;
};

/// Reads the files. Errors: a file is wrong, or it is not clear which camera is which; the message
/// is for the person who named the files.
Result<PartialRig> read_rig(const RigFiles &files);
/// The same of one file's text; `path` stands in messages.
Result<PartialRig> parse_rig(const std::string &text, const std::string &path);

/// RigCalibration::tof_delay_s; of both cameras.
double delay_s(const PartialRig &rig);

/// The whole calibration. Errors: a part is missing or not allowed.
Result<RigCalibration> whole(const PartialRig &rig);

} // namespace afterglow
