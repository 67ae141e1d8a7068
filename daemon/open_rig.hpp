// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/result.hpp"
#include "drivers/source.hpp"

namespace afterglow {

/// Opens, and does not start, the devices that the configuration names.
Result<Rig> open_rig(const Config &config);

} // namespace afterglow
