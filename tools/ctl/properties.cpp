// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/properties.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace afterglow {
namespace {

struct Unit {
    std::string_view property;
    std::string_view unit;
};

constexpr Unit units[] = {
    {"BudgetBurst", "frames"},
    {"CoverageFloor", "%"},
    {"CorePower", "W"},
    {"Coverage", "%"},
    {"CpuLoad", "s/s (measured)"},
    {"DutyCycle", "%"},
    {"DutyCycleBudget", "%"},
    {"EffectiveMaxAge", "ms"},
    {"EffectiveTargetError", "%"},
    {"EstimatedPower", "W"},
    {"ExpectedError", "%"},
    {"IdlePower", "W"},
    {"IntervalFrames", "frames"},
    {"LatencyP50", "ns"},
    {"LatencyP99", "ns"},
    {"LongestInterval", "frames"},
    {"MeasurementPrice", "frames"},
    {"PairingErrorP50", "ns"},
    {"PairingErrorP99", "ns"},
    {"ShortestInterval", "frames"},
    {"TargetError", "%"},
    {"TofPower", "W"},
    {"WakeLatency", "ns"},
};

} // namespace

std::string text(const Json &properties, const char *name) {
    const auto property = properties.find(name);
    return property != properties.end() && property->is_string()
               ? printable(property->get<std::string>())
               : "unknown";
}

double number(const Json &properties, const char *name) {
    const auto property = properties.find(name);
    if (property == properties.end())
        return 0;
    if (property->is_boolean())
        return property->get<bool>() ? 1 : 0;
    return property->is_number() ? property->get<double>() : 0;
}

Json scalars(const Json &properties) {
    Json object = Json::object();
    for (const auto &[name, value] : properties.items())
        if (value.is_primitive())
            object[json_key(name)] = value;
    return object;
}

std::string_view unit(std::string_view property) {
    const auto *known = std::find_if(std::begin(units), std::end(units),
                                     [&](const Unit &each) { return each.property == property; });
    return known == std::end(units) ? std::string_view() : known->unit;
}

std::string with_unit(const Json &value, std::string_view unit) {
    const std::string content = value.is_string()    ? printable(value.get<std::string>())
                                : value.is_boolean() ? (value.get<bool>() ? "yes" : "no")
                                : value.is_number_float()
                                    ? fmt::format("{:.6g}", value.get<double>())
                                : value.is_number() ? value.dump()
                                                    : "?";
    return unit.empty() ? content : fmt::format("{} {}", content, unit);
}

} // namespace afterglow
