// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/running.hpp"

#include "core/base/printable.hpp"
#include "core/calibration_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

namespace afterglow {
namespace {

std::string_view unit_of(std::string_view name) {
    for (std::size_t i = 0; i < calibration_parts; ++i)
        if (const auto part = static_cast<CalibrationPart>(i); to_string(part) == name)
            return calibration_unit(part).name;
    return {};
}

/// Calls visit(part's name, the numbers behind it) for each entry of a property that is a list.
template <class Visit>
void for_each_entry(const Json &properties, const char *property, std::size_t numbers,
                    const Visit &visit) {
    const auto list = properties.find(property);
    if (list == properties.end() || !list->is_array())
        return;
    for (const Json &entry : *list)
        if (entry.is_array() && entry.size() == numbers + 1 && entry[0].is_string() &&
            std::all_of(entry.begin() + 1, entry.end(),
                        [](const Json &value) { return value.is_number(); }))
            visit(printable(entry[0].get<std::string>()), entry);
}

} // namespace

Result<PartialRig> running_rig(const Json &properties) {
    const auto calibration = properties.find("Calibration");
    if (calibration == properties.end() || !calibration->is_string())
        return Error{"this afterglowd does not tell its calibration", ENODATA};
    if (calibration->get<std::string>().empty())
        return Error{"afterglowd works without a calibration file: depth is registered to the "
                     "colour camera",
                     ENODATA};
    return parse_rig(*calibration, "afterglowd");
}

std::vector<JudgedPart> judged_parts(const Json &properties) {
    std::vector<JudgedPart> parts;
    const auto named = [&](const std::string &name) -> JudgedPart & {
        const auto known =
            std::ranges::find_if(parts, [&](const JudgedPart &each) { return each.part == name; });
        if (known != parts.end())
            return *known;
        JudgedPart &added = parts.emplace_back();
        added.part = name;
        added.unit = unit_of(name);
        return added;
    };
    for_each_entry(properties, "CalibrationSuspects", 2,
                   [&](const std::string &name, const Json &entry) {
                       JudgedPart &part = named(name);
                       part.suspect = true;
                       part.amount = entry[1].get<double>();
                       part.deviation = entry[2].get<double>();
                   });
    for_each_entry(properties, "CalibrationCorrections", 1,
                   [&](const std::string &name, const Json &entry) {
                       named(name).corrected = entry[1].get<double>();
                   });
    return parts;
}

std::string describe(const JudgedPart &part) {
    std::string text = part.part;
    if (part.suspect)
        text += fmt::format(" off by {:.2f} {} (deviation {:.2f}),", part.amount, part.unit,
                            part.deviation);
    return text + (part.corrected != 0
                       ? fmt::format(" corrected by {:.2f} {}", part.corrected, part.unit)
                       : " not corrected");
}

Json json_of(const std::vector<JudgedPart> &parts) {
    Json list = Json::array();
    for (const JudgedPart &part : parts) {
        Json &entry = list.emplace_back(Json{{"part", part.part},
                                             {"unit", std::string(part.unit)},
                                             {"suspect", part.suspect},
                                             {"corrected", part.corrected}});
        if (part.suspect) {
            entry["amount"] = part.amount;
            entry["deviation"] = part.deviation;
        }
    }
    return list;
}

} // namespace afterglow
