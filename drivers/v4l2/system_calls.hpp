// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// The system calls of the V4L2 drivers whose results depend on a camera. Unit tests replace them
/// by a fake camera. Any thread.
class SystemCalls {
public:
    virtual ~SystemCalls() = default;

    /// Paths of all video nodes there are, in a steady order.
    virtual std::vector<std::string> video_nodes() = 0;
    /// Opens a node for reading and writing, not blocking. -1 and errno on failure.
    virtual int open(const std::string &path) = 0;
    /// ioctl(2), begun again when a signal interrupts it. -1 and errno on failure.
    virtual int ioctl(int fd, unsigned long request, void *argument) = 0;
    /// Waits until a buffer can be dequeued: poll(2) for POLLIN. Returns the events, 0 when the
    /// time is over.
    virtual int poll(int fd, std::chrono::nanoseconds timeout) = 0;
    /// CLOCK_MONOTONIC.
    virtual std::int64_t now_ns() = 0;
};

/// The real ones.
SystemCalls &linux_calls();

} // namespace afterglow
