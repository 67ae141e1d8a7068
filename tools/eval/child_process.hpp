// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.hpp"

#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

namespace afterglow {

/// A program that ends when this does, at the latest with the thread that started it.
class ChildProcess {
public:
    static Result<ChildProcess> start(const std::vector<std::string> &command);
    ChildProcess(ChildProcess &&other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
    ChildProcess &operator=(ChildProcess &&) = delete;
    /// Asks it to end (SIGTERM), waits three seconds, kills it.
    ~ChildProcess();

    bool running();

private:
    explicit ChildProcess(pid_t pid) : pid_(pid) {}
    pid_t pid_ = -1;
};

} // namespace afterglow
