// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"

#include <cstdint>
#include <span>

namespace afterglow {

/// What a plane of a ring holds.
struct PlaneFormat {
    std::uint32_t kind;   ///< enum afterglow_plane_kind
    std::uint32_t format; ///< AFTERGLOW_FORMAT_...
    std::uint32_t pixel_bytes;
    double unit; ///< what 1 stands for; 0: nothing
};

/// One sealed shared memory with the layout of afterglow/ring.h, and the only writable mapping of
/// it that there can be.
///
/// The functions that write are real-time safe: stores, no system call. One thread writes at a
/// time; the constants may be read by any.
class RingMemory {
public:
    /// A memory that is not in use yet (`first` is UINT64_MAX), of 2 to 1024 slots. Errors: the
    /// errno of what refused memory, seals or a read-only descriptor (which needs /proc).
    static Result<RingMemory> create(int width, int height, std::span<const PlaneFormat> planes,
                                     int slots, std::uint64_t generation);
    RingMemory(RingMemory &&other) noexcept;
    RingMemory &operator=(RingMemory &&) = delete;
    ~RingMemory() { unmap(); }

    /// A read-only descriptor with an open file description of its own, for one reader: it can be
    /// mapped read-only and nothing else.
    Result<UniqueFd> reader_fd() const;
    /// Whether anybody else has the memory open or mapped, or a descriptor of it is under way.
    bool held_by_others() const;
    const afterglow_ring_header &header() const { return *header_; }

    /// Starts its use: the next frame is `index`, and none before it is here.
    void begin_at(std::uint64_t index);
    /// Begins to overwrite the slot of frame `index`.
    void begin_frame(std::uint64_t index);
    /// Stores rows of a plane of frame `index`, from `first` on. Several threads may, of different
    /// rows, between begin_frame() and end_frame().
    void store_plane(std::uint64_t index, int plane, ImageView<const std::uint8_t> rows,
                     int first = 0);
    void store_plane(std::uint64_t index, int plane, ImageView<const std::uint16_t> rows,
                     int first = 0);
    /// Completes the slot and makes frame.index the newest.
    void end_frame(const afterglow_frame &frame);
    /// Empties all slots: no frame published so far can be read any more.
    void clear();
    void set_state(afterglow_writer_state state);
    /// Gives the writable mapping up; only the questions about readers are allowed after it.
    void unmap();

private:
    RingMemory(UniqueFd fd, void *memory, std::uint64_t bytes)
        : fd_(std::move(fd)), header_(static_cast<afterglow_ring_header *>(memory)), bytes_(bytes) {
    }
    afterglow_slot_header &slot(std::uint64_t index) const;
    template <class T>
    void store_rows(std::uint64_t index, int plane, ImageView<const T> rows, int first);

    UniqueFd fd_; ///< read-only, and of its file description there is no other descriptor
    afterglow_ring_header *header_ = nullptr;
    std::uint64_t bytes_ = 0;
};

} // namespace afterglow
