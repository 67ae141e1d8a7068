// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/reader/ring_view.hpp"

#include <span>

namespace afterglow {

/// What comes of reading a frame.
enum class ReadResult { whole, overwritten, missing, damaged };

/// A frame that is read in place.
struct PeekedFrame {
    SlotReading depth;
    SlotReading images; ///< without bytes where the stream has no images
};

/// The memories of a stream, seen as one: that with depth and, if the stream has images, theirs.
class RingPair {
public:
    /// Takes the descriptors; `images` may be none. Errors as RingView::open(); -EPROTO also for
    /// memories that do not belong together.
    static int open(const UniqueFd &depth, const UniqueFd &images, RingPair &pair);

    explicit operator bool() const { return static_cast<bool>(depth_); }
    const afterglow_ring_header &header() const { return depth_.header(); }
    const afterglow_plane *plane(std::uint32_t kind) const;
    /// Whether a buffer that fits a plane of `other` fits the same of this one.
    bool same_planes(const RingPair &other) const;

    /// Frames from first() to head() - 1 have been published here; no image of others is there.
    std::uint64_t first() const;
    std::uint64_t head() const;
    /// A frame that nobody has seen is published here next; 0 before the memory is in use.
    std::uint64_t next() const { return depth_.head(); }
    bool in_use() const;
    bool has_frames() const { return in_use() && head() > first(); }
    bool closed() const { return depth_.writer_state() == AFTERGLOW_WRITER_CLOSED; }

    /// Copies frame `index` and planes of it out; every buffer's plane exists and fits.
    ReadResult copy(std::uint64_t index, afterglow_frame &frame,
                    std::span<const afterglow_buffer> buffers) const;
    /// Points the views, whose planes exist, at frame `index`.
    ReadResult peek(std::uint64_t index, afterglow_frame &frame, std::span<afterglow_view> views,
                    PeekedFrame &peeked) const;
    static bool still_whole(const PeekedFrame &peeked);

private:
    ReadResult begin(std::uint64_t index, PeekedFrame &slots) const;
    ReadResult end(std::uint64_t index, const PeekedFrame &slots,
                   const afterglow_frame &frame) const;
    const SlotReading &slot_of(const afterglow_plane &plane, const PeekedFrame &slots) const;

    RingView depth_;
    RingView images_;
};

} // namespace afterglow
