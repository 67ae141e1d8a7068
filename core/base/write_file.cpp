// SPDX-License-Identifier: Apache-2.0
#include "core/base/write_file.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace afterglow {
namespace {

Error cannot_be_written(const std::string &path) {
    return {fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)), errno};
}

} // namespace

Result<OutputFile> OutputFile::open(const std::string &path, mode_t mode) {
    struct stat about = {};
    const bool is_replaced = ::lstat(path.c_str(), &about) != 0 || S_ISREG(about.st_mode);
    std::string part = is_replaced ? fmt::format("{}.{}.part", path, ::getpid()) : "";
    if (is_replaced)
        ::unlink(part.c_str()); // of a process that had our number and did not finish
    UniqueFd file(::open(is_replaced ? part.c_str() : path.c_str(),
                         O_WRONLY | O_CREAT | O_CLOEXEC | (is_replaced ? O_EXCL : O_TRUNC), mode));
    if (!file)
        return cannot_be_written(path);
    return OutputFile(path, std::move(part), std::move(file));
}

OutputFile::~OutputFile() {
    if (file_ && !part_.empty())
        ::unlink(part_.c_str());
}

Error OutputFile::error() const {
    return cannot_be_written(path_);
}

Status OutputFile::write(std::string_view bytes) && {
    return write_all(fd(), bytes) ? finish() : Status(error());
}

Status OutputFile::finish() {
    // Some file systems tell only at the end that there is no room.
    const bool closed = ::close(file_.release()) == 0;
    if (closed && (part_.empty() || std::rename(part_.c_str(), path_.c_str()) == 0))
        return ok();
    Error failed = error();
    if (!part_.empty())
        ::unlink(part_.c_str());
    return failed;
}

Status write_file(const std::string &path, std::string_view bytes) {
    Result<OutputFile> file = OutputFile::open(path);
    return file ? std::move(*file).write(bytes) : Status(file.error());
}

Status write_new_file(const std::string &path, std::string_view bytes) {
    UniqueFd file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file)
        return cannot_be_written(path);
    if (write_all(file.get(), bytes) && ::close(file.release()) == 0)
        return ok();
    Error failed = cannot_be_written(path);
    ::unlink(path.c_str());
    return failed;
}

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

} // namespace afterglow
