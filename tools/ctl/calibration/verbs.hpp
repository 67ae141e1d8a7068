// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/ctl/calibration/rig_files.hpp"
#include "tools/ctl/command.hpp"

#include <string>

namespace afterglow {

// What `afterglowctl calibration` does, writing to stdout. They give the program's exit status.

/// Prints what the files say; without files, what the daemon works with.
Result<int> show_calibration(const RigFiles &files, const Settings &settings);
/// Prints what is suspicious in it; then the status is 1. Without files, of what the daemon works
/// with, and what it has found to be wrong and corrects.
Result<int> check_calibration(const RigFiles &files, const Settings &settings);
/// Writes the daemon's calibration file, which must be new; to stdout if `path` is empty.
Result<int> convert_calibration(const RigFiles &files, const std::string &path,
                                const Settings &settings);

} // namespace afterglow
