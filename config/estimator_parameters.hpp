// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/parameter.hpp"
#include "core/estimator_options.hpp"
#include "core/gate.hpp"

#include <span>
#include <string_view>

namespace afterglow {

/// What can be tuned about the way depth is made.
struct Tuning {
    EstimatorOptions &estimator;
    GatePolicy &gate;
};

/// Every parameter of the estimator ("ransac.threshold"; in TOML under [estimator]) and of the
/// gate ("gate.mode"). A new option of either gets its row here, and with it its TOML key, its
/// `--set`, its bounds and its line in the reference.
std::span<const Parameter<const Tuning>> estimator_parameters();

/// The names estimator_preset() knows.
std::span<const std::string_view> estimator_preset_names();

/// Sets one parameter from text, as `afterglow-eval --set key=value` does.
Status set_parameter(EstimatorOptions &estimator, GatePolicy &gate, std::string_view key,
                     std::string_view value);

} // namespace afterglow
