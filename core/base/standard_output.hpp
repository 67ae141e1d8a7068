// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace afterglow {

/// Writes out what stdout still holds. Errors: some of what was printed was not written, with the
/// errno of the last attempt (ENOSPC: the disk is full). To be called before a program ends.
inline Status flush_standard_output() {
    errno = 0;
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0)
        return ok();
    const int code = errno != 0 ? errno : EIO;
    return Error{std::string("standard output cannot be written: ") + std::strerror(code), code};
}

} // namespace afterglow
