// SPDX-License-Identifier: Apache-2.0
#include "config/read_text.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace afterglow {

Result<std::string> read_text(const std::string &path) {
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    if (file)
        text << file.rdbuf();
    // An empty file is readable, but streams nothing.
    if (!file || (!text && errno != 0))
        return Error{fmt::format("{}: cannot be read: {}", printable(path),
                                 std::strerror(errno != 0 ? errno : EIO)),
                     errno != 0 ? errno : EIO};
    return text.str();
}

} // namespace afterglow
