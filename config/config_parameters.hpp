// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "config/parameter.hpp"

#include <span>

namespace afterglow {

/// Every key of a configuration file but those of the estimator and the gate, which stand in
/// config/estimator_parameters.hpp.
std::span<const Parameter<Config>> config_parameters();

} // namespace afterglow
