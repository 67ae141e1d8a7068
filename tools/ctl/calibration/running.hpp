// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/ctl/calibration/rig_files.hpp"
#include "tools/ctl/json.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

// What the properties of the running daemon say of its calibration.

/// The cameras that it works with. Errors: it has no calibration file.
Result<PartialRig> running_rig(const Json &properties);

/// A part of the calibration that the running daemon says is wrong, or corrects.
struct JudgedPart {
    std::string part;
    double amount = 0, deviation = 0; ///< of a suspect part
    double corrected = 0;             ///< 0: not at all
    bool suspect = false;
    std::string_view unit = {}; ///< of all; "" of a part that is not known here
};

/// In the properties' order.
std::vector<JudgedPart> judged_parts(const Json &properties);

/// "rotation off by 2.00 degrees (deviation 0.10), corrected by 2.00 degrees".
std::string describe(const JudgedPart &part);
Json json_of(const std::vector<JudgedPart> &parts);

} // namespace afterglow
