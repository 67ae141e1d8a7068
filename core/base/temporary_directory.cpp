// SPDX-License-Identifier: Apache-2.0
#include "core/base/temporary_directory.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace afterglow {

Result<TemporaryDirectory> TemporaryDirectory::create(const std::string &prefix) {
    const char *parent = std::getenv("TMPDIR");
    std::string path = parent != nullptr && *parent != '\0' ? parent : "/tmp";
    path += "/" + prefix + "XXXXXX";
    if (::mkdtemp(path.data()) == nullptr)
        return Error{"a temporary directory " + path + " cannot be made: " + std::strerror(errno),
                     errno};
    return TemporaryDirectory(path);
}

TemporaryDirectory::~TemporaryDirectory() {
    std::error_code ignored; // what is left behind can only be left behind
    if (!path_.empty())
        std::filesystem::remove_all(path_, ignored);
}

} // namespace afterglow
