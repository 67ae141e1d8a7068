// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "ipc/service.hpp"

namespace afterglow {

/// "system", "session", or the address of a bus.
BusOptions bus_named(const std::string &name);

/// Serves org.afterglow.Depth1 until SIGINT, SIGTERM, SIGHUP or, once a recording is over, until
/// the last reader leaves. SIGHUP reloads nothing; where it is ignored (nohup) it stays ignored.
/// When serve() returns the light is dark, or a failure to darken it was logged. Called once, by
/// the main thread, before there is any other: it blocks these signals for all later threads.
/// SIGPIPE has to be ignored.
Status serve(const Config &config);

} // namespace afterglow
