// SPDX-License-Identifier: Apache-2.0
#include "config/calibration_file.hpp"
#include "tools/ctl/calibration/verbs.hpp"
#include "tools/ctl/print_or_write.hpp"

#include <fmt/format.h>

namespace afterglow {

Result<int> convert_calibration(const RigFiles &files, const std::string &path,
                                const Settings &settings) {
    const Result<PartialRig> partial = read_rig(files);
    if (!partial)
        return partial.error();
    const Result<RigCalibration> rig = whole(*partial);
    if (!rig)
        return rig.error();
    return print_or_write("calibration", calibration_toml(*rig), path, settings.json);
}

} // namespace afterglow
