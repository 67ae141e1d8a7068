// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "tools/characterise/characterise.hpp"

#include <string>

namespace afterglow {

/// Tables of a configuration file with what was measured, and in comments how well it is known and
/// what it does not cover; `config` is that of the rig.
std::string report(const Characteristics &found, const Config &config);

} // namespace afterglow
