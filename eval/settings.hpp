// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimator_options.hpp"
#include "core/gate.hpp"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace afterglow {

/// Every parameter of estimator and gate with its value: an object whose keys are those of `--set`.
nlohmann::json parameters_json(const EstimatorOptions &estimator, const GatePolicy &gate);
/// Those that the estimator's method uses, for a person: value, what is allowed, and what it means.
std::string parameters_text(const EstimatorOptions &estimator, const GatePolicy &gate);

} // namespace afterglow
