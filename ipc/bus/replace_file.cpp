// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/replace_file.hpp"

#include "core/base/unique_fd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace afterglow {
namespace {

bool write_all(int fd, std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = ::write(fd, text.data(), text.size());
        if (written < 0 && errno != EINTR)
            return false;
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return ::fsync(fd) == 0;
}

} // namespace

Status replace_file(const std::string &path, std::string_view text) {
    const auto failed = [&](int error) {
        return Error{fmt::format("{}: cannot be written: {}", path, std::strerror(error)), error};
    };
    std::string temporary = path + ".XXXXXX";
    const UniqueFd file(::mkostemp(temporary.data(), O_CLOEXEC));
    if (!file)
        return failed(errno);
    if (!write_all(file.get(), text) || ::rename(temporary.c_str(), path.c_str()) < 0) {
        const int error = errno;
        ::unlink(temporary.c_str());
        return failed(error);
    }
    // The new name lasts, too, when the power fails.
    const std::string folder = std::filesystem::absolute(path).parent_path().string();
    const UniqueFd opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!opened || ::fsync(opened.get()) < 0)
        return failed(errno);
    return ok();
}

} // namespace afterglow
