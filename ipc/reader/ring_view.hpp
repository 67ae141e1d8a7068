// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "core/base/unique_fd.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace afterglow {

/// The result of reading from a slot.
enum class SlotState { whole, overwritten, empty };

/// A slot that is being read.
struct SlotReading {
    const unsigned char *bytes = nullptr;
    std::uint64_t sequence = 0; ///< that it had at the beginning
};

/// One shared memory of a stream, mapped for reading, whose header has been checked and copied:
/// what the writer does to it later cannot lead a read outside of the memory.
///
/// Sizes are those of the writer: its structs may be shorter or longer than this library's. Fields
/// that it does not have are zeros.
class RingView {
public:
    RingView() = default;
    RingView(RingView &&other) noexcept { *this = std::move(other); }
    RingView &operator=(RingView &&other) noexcept;
    ~RingView();

    /// Checks seals, size and header of `memfd` and maps it. Returns 0, -EPROTO, -EPROTONOSUPPORT
    /// or -EPERM as afterglow_open_fd(), or what mmap() gave.
    static int open(const UniqueFd &memfd, RingView &view);

    explicit operator bool() const { return memory_ != nullptr; }
    /// As found at open(): what the writer changes is history.
    const afterglow_ring_header &header() const { return header_; }
    /// The planes that this library can read.
    std::span<const afterglow_plane> planes() const { return {planes_, plane_count_}; }
    const afterglow_plane *plane(std::uint32_t kind) const;
    static std::size_t row_bytes(const afterglow_plane &plane) {
        return std::size_t{plane.width} * plane.pixel_bytes;
    }

    // What the writer changes.
    std::uint64_t head() const;
    std::uint64_t first() const; ///< UINT64_MAX: not in use yet
    std::uint32_t writer_state() const;

    /// Whether frame `index` is in its slot; then what is read of `slot` counts if still_whole()
    /// says so afterwards.
    SlotState begin(std::uint64_t index, SlotReading &slot) const;
    static bool still_whole(const SlotReading &slot);
    void copy_frame(const SlotReading &slot, afterglow_frame &frame) const;
    static void copy_plane(const SlotReading &slot, const afterglow_plane &plane, void *to);

private:
    int read_header();
    int read_planes();
    const afterglow_ring_header &live() const {
        return *static_cast<const afterglow_ring_header *>(memory_);
    }

    const void *memory_ = nullptr;
    std::size_t size_ = 0;
    afterglow_ring_header header_{};
    afterglow_plane planes_[AFTERGLOW_MAX_PLANES]{};
    std::size_t plane_count_ = 0;
};

} // namespace afterglow
