// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/unique_fd.hpp"

namespace afterglow {

/// Calls OpenStream of org.afterglow.Depth1. `bus` and errors as for afterglow_open().
int open_stream(const char *bus, UniqueFd &memfd, UniqueFd &socket);

} // namespace afterglow
