// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/bus.hpp"

namespace afterglow {

/// Makes a copy of `call` to be kept and dispatched later. The copy has the same sender, arguments
/// and serial number, so that its answer is the answer to `call`. It has no file descriptors, also
/// not those that came with `call` and that no argument names; and its size is bounded.
///
/// Returns 0 or a negative errno: -E2BIG where there is more than any method takes, -EINVAL where
/// an argument is a descriptor, which none takes. `call` is left rewound.
int copy_call(sd_bus_message *call, BusMessage &copy);

} // namespace afterglow
