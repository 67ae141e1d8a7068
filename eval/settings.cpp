// SPDX-License-Identifier: Apache-2.0
#include "eval/settings.hpp"

#include "config/parameter_table.hpp"
#include "eval/json.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

/// The text of a parameter's value in JSON.
struct ValueText {
    const Allowed &allowed;

    std::string operator()(const std::string *value) const { return json_string(*value); }
    std::string operator()(EnumField value) const {
        return json_string(std::string(allowed.choices[*value.index]));
    }
    template <class Plain>
    std::string operator()(const Plain *value) const {
        return fmt::format("{}", *value);
    }
};

} // namespace

std::string parameters_json(const EstimatorOptions &estimator, const GatePolicy &gate) {
    Config config;
    config.estimator = estimator;
    config.gate = gate;
    const ParameterTable table = ParameterTable::of_estimator(config);
    std::string out;
    for (const Parameter &row : table.rows())
        out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", row.key,
                           std::visit(ValueText{row.allowed}, row.field));
    return "{" + out + "}";
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
