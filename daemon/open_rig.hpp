// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"

namespace afterglow {

/// Opens, and does not start, the devices that the configuration names. A real light is switched
/// by a thread of its own (LightSwitch).
Result<Rig> open_rig(const Config &config);

/// Switches the configured light off, whoever left it on. A simulated light needs no switching.
/// Errors: the device is absent, in use, or cannot be switched.
Status darken(const Config &config);

} // namespace afterglow
