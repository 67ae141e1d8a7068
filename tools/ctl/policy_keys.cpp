// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/policy_keys.hpp"

#include "config/parameter.hpp"
#include "core/base/printable.hpp"
#include "tools/ctl/properties.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <vector>

namespace afterglow {
namespace {

constexpr PolicyKey keys[] = {
    {"Mode", 's', "EffectiveMode", "mode"},
    {"IntervalFrames", 'u'},
    {"TargetError", 'd', "EffectiveTargetError", "max_relative_error"},
    {"MeasurementPrice", 'd'},
    {"CoverageFloor", 'd'},
    {"ShortestInterval", 'u'},
    {"LongestInterval", 'u', "EffectiveMaxAge", "max_age_ms"},
    {"DutyCycleBudget", 'd'},
    {"BudgetBurst", 'd'},
    {"TofPower", 'd'},
    {"IdlePower", 'd'},
    {"CorePower", 'd'},
};

std::string letters(std::string_view name) {
    std::string kept;
    for (const char letter : name)
        if (letter != '-' && letter != '_')
            kept += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    return kept;
}

template <class Number>
Number parse(const PolicyKey &key, const std::string &text, const char *what) {
    Number number{};
    const char *end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || rest != end)
        throw CLI::ValidationError(
            fmt::format("{} is {}, and \"{}\" is not", key.name, what, printable(text)));
    return number;
}

} // namespace

std::span<const PolicyKey> policy_keys() {
    return keys;
}

const PolicyKey &policy_key(const std::string &name) {
    const auto *key = std::find_if(std::begin(keys), std::end(keys), [&](const PolicyKey &each) {
        return letters(each.name) == letters(name);
    });
    if (key != std::end(keys))
        return *key;
    std::vector<std::string_view> names;
    for (const PolicyKey &each : keys)
        names.emplace_back(each.name);
    const std::string hint = suggestion(name, names);
    throw CLI::ValidationError(fmt::format("the policy has no key \"{}\"{}", printable(name),
                                           hint.empty() ? "; `policy get` shows all" : hint));
}

PolicyValue policy_value(const PolicyKey &key, const std::string &text) {
    switch (key.type) {
    case 'u':
        return parse<std::uint32_t>(key, text, "a number of frames");
    case 'd':
        return parse<double>(key, text, "a number");
    default:
        return text;
    }
}

Json describe_key(const PolicyKey &key, const Json &properties, const Json &requests) {
    Json description = {{"value", properties.value(key.name, Json())}, {"unit", unit(key.name)}};
    const Json ranges = properties.value("Ranges", Json::object());
    if (const auto range = ranges.find(key.name); range != ranges.end() && range->size() == 2) {
        description["minimum"] = (*range)[0];
        description["maximum"] = (*range)[1];
    }
    const auto effective = properties.find(key.effective);
    if (effective == properties.end())
        return description;
    // 0 ms is no limit.
    description["effective"] = *effective == 0 ? Json() : *effective;
    description["effective_unit"] = unit(key.effective);
    Json &asked_by = description["asked_by"] = Json::array();
    std::copy_if(requests.begin(), requests.end(), std::back_inserter(asked_by),
                 [&](const Json &request) {
                     const auto wish = request.find(key.wish);
                     return wish != request.end() && *wish == *effective && *wish != 0;
                 });
    return description;
}

} // namespace afterglow
