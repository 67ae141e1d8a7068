// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace afterglow {

/// How a child process begins. It always has an empty signal mask, default signal actions and the
/// ordinary scheduler (SCHED_OTHER), whatever the starting thread has.
struct ChildOptions {
    std::vector<std::string> command; ///< [0]: a path, or a name that is looked for in PATH
    /// Besides this process's environment: "NAME=value" sets a variable, "NAME" removes it.
    std::vector<std::string> environment{};
    /// (ours, the child's): descriptors that the child gets under the second number, one after the
    /// other: no second number may be the first one of a later pair.
    std::vector<std::pair<int, int>> descriptors{};
    /// Sent by the destructor, and by the kernel when the thread that started the child ends.
    int end_signal = SIGKILL;
};

/// A program that runs as a child of this process, and ends with this object at the latest.
/// One thread at a time; nothing here is real-time safe.
class ChildProcess {
public:
    /// Starts the program without copying this process's memory (vfork). Errors: the errno of
    /// vfork() or execvpe(), ENOENT where there is no such program.
    static Result<ChildProcess> start(const ChildOptions &options);
    ChildProcess(ChildProcess &&other) noexcept
        : pid_(std::exchange(other.pid_, -1)), end_signal_(other.end_signal_), code_(other.code_) {}
    ChildProcess &operator=(ChildProcess &&) = delete;
    /// Sends the end signal and waits 3 seconds at most, unless it is SIGKILL; then sends SIGKILL
    /// and waits 1 second at most, because the kernel may hold the process in a driver.
    ~ChildProcess();

    pid_t pid() const { return pid_; } ///< -1 when it has ended
    void signal(int number) const;
    bool running();
    /// Waits for the end, `time` at most: the exit status, or the negative number of the signal
    /// that killed it; nothing while it still runs.
    std::optional<int> wait(std::chrono::milliseconds time);

private:
    ChildProcess(pid_t pid, int end_signal) : pid_(pid), end_signal_(end_signal) {}
    pid_t pid_;
    int end_signal_;
    int code_ = 0;
};

} // namespace afterglow
