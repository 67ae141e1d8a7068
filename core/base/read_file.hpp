// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cstddef>
#include <string>

namespace afterglow {

/// The bytes of a regular file of at most `most_bytes`. Never waits: a pipe or a device is refused.
/// Errors carry errno and say `PATH: cannot be read: why`.
Result<std::string> read_file(const std::string &path, std::size_t most_bytes = 64 << 20);

} // namespace afterglow
