// SPDX-License-Identifier: Apache-2.0
#include "drivers/files/read_file.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace afterglow {
namespace {

constexpr off_t max_file_bytes = off_t{64} << 20;

Error system_error(const std::string &path) {
    return {fmt::format("{}: {}", printable(path), std::strerror(errno)), errno};
}

Result<std::string> read_descriptor(int fd, const std::string &path) {
    struct stat info;
    if (fstat(fd, &info) != 0)
        return system_error(path);
    if (!S_ISREG(info.st_mode))
        return Error{fmt::format("{}: is not a regular file", printable(path)), EINVAL};
    if (info.st_size > max_file_bytes)
        return Error{fmt::format("{}: has {} bytes, more than the {} that are read",
                                 printable(path), info.st_size, max_file_bytes),
                     EFBIG};
    std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
    std::size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t count = read(fd, bytes.data() + filled, bytes.size() - filled);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return system_error(path);
        if (count == 0) // it became shorter meanwhile
            break;
        filled += static_cast<std::size_t>(count);
    }
    bytes.resize(filled);
    return bytes;
}

} // namespace

Result<std::string> read_file(const std::string &path) {
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        return system_error(path);
    Result<std::string> bytes = read_descriptor(fd, path);
    close(fd);
    return bytes;
}

} // namespace afterglow
