// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {

/// A program that ends when this does, at the latest with the thread that started it.
class ChildProcess {
public:
    /// What it writes to standard error goes to the file `log`, or where ours goes.
    static Result<ChildProcess> start(const std::vector<std::string> &command,
                                      const std::string &log = {});
    ChildProcess(ChildProcess &&other) noexcept
        : pid_(std::exchange(other.pid_, -1)), code_(other.code_) {}
    ChildProcess &operator=(ChildProcess &&) = delete;
    /// Asks it to end (SIGTERM), waits three seconds, kills it.
    ~ChildProcess();

    bool running();
    /// Waits three seconds for its end: its exit status, 128 + the number of the signal that
    /// killed it, or nothing while it still runs.
    std::optional<int> wait();

private:
    explicit ChildProcess(pid_t pid) : pid_(pid) {}
    pid_t pid_ = -1;
    int code_ = 0;
};

} // namespace afterglow
