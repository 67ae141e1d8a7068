// SPDX-License-Identifier: Apache-2.0
#include "eval/settings.hpp"

#include "config/estimator_parameters.hpp"
#include "eval/json.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

/// The text of a parameter's value in JSON.
struct ValueText {
    const Allowed &allowed;

    std::string operator()(const std::string *value) const { return json_string(*value); }
    std::string operator()(EnumField value) const {
        return json_string(std::string(allowed.choices[*value.place]));
    }
    template <class Plain>
    std::string operator()(const Plain *value) const {
        return fmt::format("{}", *value);
    }
};

} // namespace

std::string parameters_json(EstimatorOptions estimator, GatePolicy gate) {
    const Tuning tuning{estimator, gate};
    std::string out;
    for (const auto &parameter : estimator_parameters())
        out += fmt::format("{}\"{}\": {}", out.empty() ? "" : ", ", parameter.key,
                           std::visit(ValueText{parameter.allowed}, parameter.field(tuning)));
    return "{" + out + "}";
}

} // namespace afterglow
