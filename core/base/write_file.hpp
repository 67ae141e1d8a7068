// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <string>
#include <string_view>

namespace afterglow {

// Errors name the file and carry its errno: ENOSPC where the disk is full. No part of a regular
// file is left after one.

/// Writes a whole file, in place of what was there. `path` may be a device or a pipe, too.
Status write_file(const std::string &path, std::string_view bytes);

/// Makes a file; never over one that somebody has written (EEXIST).
Status write_new_file(const std::string &path, std::string_view bytes);

/// Writes all bytes to a descriptor that waits; false with errno where it refuses.
bool write_all(int fd, std::string_view bytes);

} // namespace afterglow
