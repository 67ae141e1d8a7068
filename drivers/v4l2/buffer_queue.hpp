// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace afterglow::v4l2 {

/// The buffers that a streaming device fills, in memory shared with its driver.
class BufferQueue {
public:
    /// Reserves, maps and queues the buffers, and begins to stream. `fd` must stay open for the
    /// queue's life; `device` is for error messages.
    static Result<BufferQueue> start(SystemCalls &calls, int fd, std::uint32_t buffer_type,
                                     const std::string &device);
    BufferQueue(BufferQueue &&other) noexcept;
    BufferQueue &operator=(BufferQueue &&) = delete;
    /// Ends the streaming and gives the buffers back.
    ~BufferQueue();

    /// Takes the oldest filled buffer out of the queue. Of several planes `bytesused` is the
    /// first's. False, and errno, where there is none.
    bool dequeue(v4l2_buffer &buffer);
    /// Queues the buffer again. False, and errno, on failure.
    bool queue(std::uint32_t index);
    /// What the driver wrote into the (first plane of the) buffer.
    std::span<const std::uint8_t> bytes(const v4l2_buffer &buffer) const;

private:
    struct Memory {
        void *begin;
        std::size_t size;
    };

    BufferQueue(SystemCalls &calls, int fd, std::uint32_t type)
        : calls_(calls), fd_(fd), type_(type) {}
    Status reserve(const std::string &device);
    bool map(std::uint32_t index);

    SystemCalls &calls_;
    int fd_; ///< -1: moved from
    std::uint32_t type_;
    std::vector<Memory> memory_;
};

} // namespace afterglow::v4l2
