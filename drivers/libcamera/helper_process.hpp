// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/libcamera/wire.hpp"

#include <sys/types.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace afterglow::libcam {

/// A process of afterglow-libcamera, for as long as this object lives. It ends with the thread that
/// started it, at the latest.
class HelperProcess {
public:
    static Result<HelperProcess> start(const std::string &program,
                                       std::vector<std::string> arguments);
    HelperProcess(HelperProcess &&other) noexcept
        : pid_(std::exchange(other.pid_, -1)), socket_(std::move(other.socket_)) {}
    HelperProcess &operator=(HelperProcess &&) = delete;
    /// Kills it, and waits a second for its end: the kernel may hold it in a driver, and then the
    /// camera is still in use when it is started again.
    ~HelperProcess();

    int socket() const { return socket_.get(); }

    /// Until a message may be there, or the time is over.
    void wait(std::chrono::nanoseconds time) const;
    /// Its next message; Received::nothing when the time is over.
    Received await(Report &report, std::vector<UniqueFd> &descriptors,
                   std::chrono::steady_clock::time_point deadline) const;

private:
    HelperProcess(pid_t pid, UniqueFd socket) : pid_(pid), socket_(std::move(socket)) {}

    pid_t pid_;
    UniqueFd socket_;
};

} // namespace afterglow::libcam
