// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/configuration.hpp"
#include "daemon/open_rig.hpp"

#include <functional>

namespace afterglow {

/// Serves org.afterglow.Depth1 until SIGINT, SIGTERM or, once a recording is over, until the last
/// reader leaves; also while there is no bus. SIGHUP reads `files` again. `config` is what they
/// said; `open` opens its devices. When serve() returns the light is dark, or a failure to darken
/// it was logged. Called once, by the main thread, before there is any other: it blocks these
/// signals for all later threads. SIGPIPE has to be ignored. Errors: the bus or a device refuses,
/// or the estimator thread fails.
Status serve(const Config &config, const ConfigurationFiles &files,
             const std::function<Result<Rig>(const Config &)> &open = open_rig);

} // namespace afterglow
