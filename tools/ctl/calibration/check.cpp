// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/rig_figures.hpp"
#include "tools/ctl/calibration/running.hpp"
#include "tools/ctl/calibration/verbs.hpp"
#include "tools/ctl/daemon.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

/// The rig, and what the running daemon has found out about it.
struct Checked {
    PartialRig rig;
    std::vector<JudgedPart> judged;
};

Result<Checked> read(const RigFiles &files, const Settings &settings) {
    if (!files.paths.empty()) {
        Result<PartialRig> rig = read_rig(files);
        if (!rig)
            return rig.error();
        return Checked{*std::move(rig), {}};
    }
    const Result<Json> properties = Daemon::properties_on(settings.bus);
    if (!properties)
        return properties.error();
    Result<PartialRig> rig = running_rig(*properties);
    if (!rig)
        return rig.error();
    return Checked{*std::move(rig), judged_parts(*properties)};
}

} // namespace

Result<int> check_calibration(const RigFiles &files, const Settings &settings) {
    const Result<Checked> checked = read(files, settings);
    if (!checked)
        return checked.error();
    const std::vector<std::string> found = suspicions(checked->rig);
    if (settings.json) {
        Json document = {{"suspicious", found}};
        if (files.paths.empty())
            document["calibration_parts"] = json_of(checked->judged);
        if (const Result<int> printed = print_json(document); !printed)
            return printed;
    } else {
        for (const std::string &sentence : found)
            fmt::print("{}\n", sentence);
        for (const JudgedPart &part : checked->judged)
            fmt::print("images and depth: {}\n", describe(part));
    }
    const bool suspect = std::ranges::any_of(checked->judged, &JudgedPart::suspect);
    return found.empty() && !suspect ? 0 : 1;
}

} // namespace afterglow
