// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/rig_figures.hpp"
#include "tools/ctl/calibration/verbs.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

namespace afterglow {

Result<int> check_calibration(const RigFiles &files, const Settings &settings) {
    const Result<PartialRig> rig = read_rig(files);
    if (!rig)
        return rig.error();
    const std::vector<std::string> found = suspicions(*rig);
    if (settings.json) {
        if (const Result<int> printed = print_json({{"suspicious", found}}); !printed)
            return printed;
    } else {
        for (const std::string &sentence : found)
            fmt::print("{}\n", sentence);
    }
    return found.empty() ? 0 : 1;
}

} // namespace afterglow
