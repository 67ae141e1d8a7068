// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimator_options.hpp"
#include "core/gate.hpp"

#include <string>

namespace afterglow {

/// Every parameter of estimator and gate with its value, as one JSON object: what `--set` takes.
std::string parameters_json(EstimatorOptions estimator, GatePolicy gate);

} // namespace afterglow
