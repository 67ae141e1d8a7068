// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/configuration.hpp"

namespace afterglow {

/// Serves org.afterglow.Depth1 until SIGINT, SIGTERM or, once a recording is over, until the last
/// reader leaves; also while there is no bus. SIGHUP reads `files` again. `config` is what they
/// said. When serve() returns the light is dark, or a failure to darken it was logged. Called once,
/// by the main thread, before there is any other: it blocks these signals for all later threads.
/// SIGPIPE has to be ignored.
Status serve(const Config &config, const ConfigurationFiles &files);

} // namespace afterglow
