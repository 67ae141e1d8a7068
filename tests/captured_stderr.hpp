// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/unique_fd.hpp"
#include "tests/temporary_folder.hpp"

#include <fcntl.h>
#include <string>
#include <unistd.h>

/// Collects what this process writes to standard error while the object lives.
class CapturedStderr {
public:
    CapturedStderr() : before_(::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3)) {
        const afterglow::UniqueFd file(
            ::open((folder_ / "err").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
        ::dup2(file.get(), STDERR_FILENO);
    }
    ~CapturedStderr() { ::dup2(before_.get(), STDERR_FILENO); }
    CapturedStderr(const CapturedStderr &) = delete;
    CapturedStderr &operator=(const CapturedStderr &) = delete;

    std::string text() const { return folder_.read("err"); }

private:
    TemporaryFolder folder_;
    afterglow::UniqueFd before_;
};
