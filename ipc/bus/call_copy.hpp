// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/bus.hpp"

namespace afterglow {

/// A call to be kept and dispatched later, of `call`, which is not kept: whatever its sender put
/// beside the arguments, as descriptors that no argument names, ends with it. The copy has the same
/// sender and is answered in the same way. Its size is bounded.
///
/// Returns 0 or a negative errno: -E2BIG where there is more than any method takes, -EINVAL where
/// an argument is a descriptor, which none takes. `call` is left rewound.
int copy_call(sd_bus_message *call, BusMessage &copy);

} // namespace afterglow
