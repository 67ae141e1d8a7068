// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/ctl/calibration/rig_files.hpp"

#include <string>

namespace afterglow {

// What `afterglowctl calibration` does, writing to stdout. They give the program's exit status.

/// Prints what the files say.
Result<int> show_calibration(const RigFiles &files, bool json);
/// Prints what is suspicious in it; then the status is 1.
Result<int> check_calibration(const RigFiles &files, bool json);
/// Writes the daemon's calibration file, which must be new; to stdout if `path` is empty.
Result<int> convert_calibration(const RigFiles &files, const std::string &path, bool json);

} // namespace afterglow
