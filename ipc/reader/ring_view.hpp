// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"

#include <cstddef>
#include <cstdint>
#include <utility>

namespace afterglow {

/// The result of reading a frame from its slot.
enum class Copied { whole, overwritten, incomplete, damaged };

/// A ring mapped for reading, whose header has been checked and copied: what the writer does to
/// it later cannot lead a read outside of the memory.
class RingView {
public:
    RingView() = default;
    RingView(RingView &&other) noexcept
        : memory_(std::exchange(other.memory_, nullptr)), size_(other.size_),
          header_(other.header_) {}
    RingView &operator=(RingView &&other) noexcept;
    ~RingView();

    /// Checks seals, size and header of `memfd`, which stays the caller's, and maps it. Returns 0,
    /// -EPROTO, -EPROTONOSUPPORT or -EPERM as afterglow_open_fds(), or what mmap() gave.
    static int open(int memfd, RingView &view);

    /// As found at open(): writer_state, futex and head in it are history.
    const afterglow_ring_header &header() const { return header_; }
    const afterglow_plane *plane(std::uint32_t kind) const;
    /// Bytes of one row of a plane without what pads it. 0: a kind unknown to this library.
    static std::uint64_t row_bytes(const afterglow_plane &plane);

    /// Number of frames published so far.
    std::uint64_t head() const;
    bool closed() const;
    /// Changes with each publication; afterglow_wait() sleeps on it.
    const std::uint32_t *futex() const;

    /// Copies frame `index` and planes of it out; every buffer's plane exists and fits.
    Copied copy(std::uint64_t index, afterglow_frame &frame, const afterglow_buffer *buffers,
                std::size_t buffer_count) const;

private:
    const afterglow_ring_header &live() const {
        return *static_cast<const afterglow_ring_header *>(memory_);
    }

    const void *memory_ = nullptr;
    std::size_t size_ = 0;
    afterglow_ring_header header_{};
};

} // namespace afterglow
