// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>

namespace afterglow {

/// The bytes of a regular file of at most 64 MiB. Never waits: a pipe or a device is refused. The
/// error's sentence begins with the path.
Result<std::string> read_file(const std::string &path);

} // namespace afterglow
