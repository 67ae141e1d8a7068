// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "tests/fuzz/require.hpp"

#include <sys/mman.h>

#include <string>
#include <string_view>
#include <unistd.h>

/// A file that is never on a disk.
class MemoryFile {
public:
    explicit MemoryFile(std::string_view content) : fd_(memfd_create("input", MFD_CLOEXEC)) {
        require(write(fd_.get(), content.data(), content.size()) ==
                    static_cast<ssize_t>(content.size()),
                "a memfd takes the input");
    }
    std::string path() const { return "/proc/self/fd/" + std::to_string(fd_.get()); }

private:
    afterglow::UniqueFd fd_;
};
