// SPDX-License-Identifier: Apache-2.0
#include "core/base/read_file.hpp"

#include "core/base/printable.hpp"
#include "core/base/unique_fd.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace afterglow {

Result<std::string> read_file(const std::string &path, std::size_t most_bytes) {
    const auto failed = [&](int code, const std::string &why) {
        return Error{fmt::format("{}: cannot be read: {}", printable(path), why), code};
    };
    const UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    struct stat info = {};
    if (!file || ::fstat(file.get(), &info) != 0)
        return failed(errno, std::strerror(errno));
    if (S_ISDIR(info.st_mode))
        return failed(EISDIR, std::strerror(EISDIR));
    if (!S_ISREG(info.st_mode))
        return failed(EINVAL, "it is not a regular file");
    if (std::cmp_greater(info.st_size, most_bytes))
        return failed(EFBIG, fmt::format("it has {} bytes, more than the {} that such a file may "
                                         "have",
                                         info.st_size, most_bytes));
    std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
    std::size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t count = ::read(file.get(), bytes.data() + filled, bytes.size() - filled);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return failed(errno, std::strerror(errno));
        if (count == 0) // it became shorter meanwhile
            break;
        filled += static_cast<std::size_t>(count);
    }
    bytes.resize(filled);
    return bytes;
}

} // namespace afterglow
