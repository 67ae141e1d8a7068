// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/ctl/json.hpp"

#include <systemd/sd-bus.h>

namespace afterglow {

/// Reads the next value of a D-Bus message as JSON: dictionaries as objects, arrays and structures
/// as arrays, a variant as what it holds; descriptors as null. `value` is null where the message
/// has no more. Returns 0 or a negative errno.
int read_value(sd_bus_message *message, Json &value);

} // namespace afterglow
