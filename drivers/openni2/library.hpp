// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

namespace afterglow::openni2 {

/// Loads OpenNI2's drivers, once. They stay loaded until the process ends, because some of Debian's
/// crash when they are unloaded. Errors: ENODEV, no driver could be loaded. Any thread.
Status load_library();

/// ENODEV with "what: why"; `why` is the library's extended error, if it has one.
Error library_error(const char *what);

} // namespace afterglow::openni2
