// SPDX-License-Identifier: Apache-2.0
#include "core/base/write_file.hpp"

#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace afterglow {

bool write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR)
            return false;
        if (written > 0)
            bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

namespace {

Status write_with(int flags, const std::string &path, std::string_view bytes) {
    UniqueFd file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0666));
    const bool opened = static_cast<bool>(file);
    // Some file systems tell only at the end that there is no room.
    if (opened && write_all(file.get(), bytes) && ::close(file.release()) == 0)
        return ok();
    const Error error{
        fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)), errno};
    struct stat about = {};
    if (opened && ::lstat(path.c_str(), &about) == 0 && S_ISREG(about.st_mode))
        ::unlink(path.c_str());
    return error;
}

} // namespace

Status write_file(const std::string &path, std::string_view bytes) {
    return write_with(O_TRUNC, path, bytes);
}

Status write_new_file(const std::string &path, std::string_view bytes) {
    return write_with(O_EXCL, path, bytes);
}

} // namespace afterglow
