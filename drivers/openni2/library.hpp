// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

namespace afterglow::openni2 {

/// Loads OpenNI2's drivers, once. They stay loaded to the end of the process: some of those that
/// Debian ships crash when they are told to end. Any thread.
Status load_library();

/// "what: why", with the library's own words where it has any.
Error library_error(const char *what);

} // namespace afterglow::openni2
