// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/reader/link.hpp"
#include "ipc/reader/ring_pair.hpp"

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>

/// A stream as the C functions see it: which memory its frames are in now, and how far they have
/// been read. All functions return 0 or a negative errno of afterglow/afterglow.h.
struct afterglow_stream {
    afterglow_stream() = default;
    afterglow_stream(const afterglow_stream &) = delete;
    afterglow_stream &operator=(const afterglow_stream &) = delete;

    /// Takes what has come from the daemon. 0, also when the stream is over but has frames left;
    /// -ECONNRESET once for each further daemon.
    int update();
    /// What it means when there is no new frame: -EAGAIN, -EINPROGRESS, or why none will come.
    int nothing_new() const;

    bool is_open() const { return static_cast<bool>(current_); }
    const afterglow::RingPair &ring() const { return current_; }
    /// Whether there is a frame that is newer than all read.
    bool has_new() const;
    std::uint64_t skipped() const { return skipped_; }
    /// Of the last frame read; zeros before.
    const afterglow_frame &last_frame() const { return last_; }

    int read(std::uint64_t index, afterglow_frame &frame,
             std::span<const afterglow_buffer> buffers);
    int read_latest(afterglow_frame &frame, std::span<const afterglow_buffer> buffers);
    int peek_latest(afterglow_frame &frame, std::span<afterglow_view> views);
    bool peek_is_whole() const { return afterglow::RingPair::still_whole(peeked_); }

    afterglow::Link link;
    struct Free {
        void operator()(char *text) const { std::free(text); }
    };
    std::unique_ptr<char, Free> bus; ///< the link's options point to it

private:
    /// Whether there are frames in the memory that was sent last, but is not read yet.
    bool follows() const { return following_.has_frames(); }
    void take(const afterglow::StreamMessage &memory);
    void mark_read(const afterglow_frame &frame);
    /// Reads from the memory that was sent last.
    void follow();
    template <class Read>
    int latest(Read read);

    afterglow::RingPair current_;
    afterglow::RingPair following_; ///< frames come here as soon as current_ has been replaced
    afterglow::PeekedFrame peeked_;
    afterglow_frame last_{};
    std::uint64_t begin_ = 0;   ///< frames below this one are older than the stream
    std::uint64_t next_ = 0;    ///< frames below this one have been read or passed over
    std::uint64_t skipped_ = 0; ///< of those, passed over since the first one read
    bool read_any_ = false;
    bool linked_ = false;  ///< the daemon of current_ is there
    bool renewed_ = false; ///< it is another than before, and the caller does not know yet
};
