// SPDX-License-Identifier: Apache-2.0
#include "eval/settings.hpp"

#include "config/parameter_table.hpp"
#include "eval/json.hpp"

#include <fmt/format.h>

#include <string>

namespace afterglow {
namespace {

/// A parameter's value in JSON: a number, a boolean, or the name of an enumerator.
struct ValueJson {
    const Allowed &allowed;

    nlohmann::json operator()(EnumField value) const { return allowed.choices[*value.index]; }
    /// The double of the same shortest text: 0.1 instead of 0.10000000149011612.
    nlohmann::json operator()(const float *value) const {
        return std::stod(fmt::format("{}", *value));
    }
    template <class Plain>
    nlohmann::json operator()(const Plain *value) const {
        return *value;
    }
};

} // namespace

nlohmann::json parameters_json(const EstimatorOptions &estimator, const GatePolicy &gate) {
    Config config;
    config.estimator = estimator;
    config.gate = gate;
    const ParameterTable table = ParameterTable::of_estimator(config);
    nlohmann::json values = nlohmann::json::object();
    for (const Parameter &row : table.rows())
        values[std::string(row.key)] = std::visit(ValueJson{row.allowed}, row.field);
    return values;
}

std::string parameters_text(const EstimatorOptions &estimator, const GatePolicy &gate) {
    Config config;
    config.estimator = estimator;
    config.gate = gate;
    const ParameterTable table = ParameterTable::of_estimator(config);
    std::string out;
    for (const Parameter &row : table.rows())
        if (!row.used_by || *row.used_by == estimator.method)
            out += fmt::format("{} = {} # {}\n    {}\n", row.key, toml_value(row), describe(row),
                               row.help);
    return out;
}

} // namespace afterglow
