// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/replace_file.hpp"

#include "core/base/unique_fd.hpp"
#include "core/base/write_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace afterglow {
Status replace_file(const std::string &path, std::string_view text) {
    const auto failed = [&](int error) {
        return Error{fmt::format("{}: cannot be written: {}", path, std::strerror(error)), error};
    };
    const std::string folder = std::filesystem::absolute(path).parent_path().string();
    const UniqueFd opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!opened)
        return failed(errno);
    std::string temporary = path + ".XXXXXX";
    const UniqueFd file(::mkostemp(temporary.data(), O_CLOEXEC));
    if (!file)
        return failed(errno);
    if (!write_all(file.get(), text) || ::fsync(file.get()) < 0 ||
        ::rename(temporary.c_str(), path.c_str()) < 0) {
        const int error = errno;
        ::unlink(temporary.c_str());
        return failed(error);
    }
    // The new name lasts, too, when the power fails.
    if (::fsync(opened.get()) < 0) {
        const int error = errno;
        return Error{fmt::format("{}: is written, but may be the old one after a power failure: {}",
                                 path, std::strerror(error)),
                     error};
    }
    return ok();
}

} // namespace afterglow
