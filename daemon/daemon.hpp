// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "ipc/service.hpp"

namespace afterglow {

/// "system", "session", or the address of a bus.
BusOptions bus_named(const std::string &name);

/// Serves org.afterglow.Depth1 until SIGINT, SIGTERM or, once a recording is over, the last reader
/// leaves. The light is dark when it returns. Called once, by the main thread, before there is any
/// other: it blocks the two signals for all threads to come.
Status serve(const Config &config);

} // namespace afterglow
