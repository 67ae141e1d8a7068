// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/new_file.hpp"

#include "core/base/printable.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>

namespace afterglow {
Status write_new(const std::string &path, const std::string &text) {
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    std::FILE *file = fd < 0 ? nullptr : ::fdopen(fd, "w");
    const bool written = file && std::fputs(text.c_str(), file) >= 0;
    const bool closed = file && std::fclose(file) == 0;
    if (!written || !closed)
        return Error{fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)),
                     errno};
    return ok();
}

Result<int> print_or_write(const char *what, const std::string &text, const std::string &path,
                           bool json) {
    if (!path.empty())
        if (const Status written = write_new(path, text); !written)
            return written.error();
    if (json)
        return print_json({{"path", path}, {what, text}});
    fmt::print("{}", path.empty() ? text : path + "\n");
    return 0;
}

} // namespace afterglow
