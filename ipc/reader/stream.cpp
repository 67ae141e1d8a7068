// SPDX-License-Identifier: Apache-2.0
#include "ipc/reader/stream.hpp"

#include <cerrno>
#include <utility>

using namespace afterglow;

namespace {

/// A copy is overtaken only when the writer goes once around the ring meanwhile.
constexpr int most_attempts = 16;
/// Whoever is at the other end could send memories for ever. The descriptor stays readable.
constexpr int most_memories = 16;

} // namespace

int afterglow_stream::update() {
    peeked_ = {};
    for (int memories = 0; memories < most_memories;) {
        const Link::Event event = link.next();
        switch (event.kind) {
        case Link::Event::Kind::memory:
            take(event.message);
            ++memories;
            continue;
        case Link::Event::Kind::lost:
            linked_ = false;
            continue;
        case Link::Event::Kind::ended:
            linked_ = false;
            break;
        case Link::Event::Kind::none:
            break;
        }
        break;
    }
    if (renewed_) {
        renewed_ = false;
        return -ECONNRESET;
    }
    return 0;
}

void afterglow_stream::take(const StreamMessage &memory) {
    RingPair pair;
    if (const int error = RingPair::open(memory.depth, memory.images, pair); error < 0) {
        link.end(error);
        return;
    }
    if (linked_) { // by the same daemon
        if (!pair.same_planes(current_)) {
            link.end(-EPROTO); // the caller's buffers fit those before
            return;
        }
        if (following_.in_use())
            follow();
        following_ = std::move(pair);
        return;
    }
    renewed_ = is_open();
    linked_ = true;
    begin_ = next_ = pair.next();
    read_any_ = false;
    last_ = {};
    current_ = std::move(pair);
    following_ = RingPair();
}

bool afterglow_stream::has_new() const {
    return follows() ? following_.head() > next_ : is_open() && current_.head() > next_;
}

int afterglow_stream::nothing_new() const {
    if (link.ended())
        return link.problem();
    if (!linked_)
        return -EINPROGRESS;
    const bool closed = (follows() ? following_ : current_).closed();
    if (!closed)
        return -EAGAIN;
    return link.reconnects() ? -EINPROGRESS : -EPIPE; // its socket's end follows
}

void afterglow_stream::follow() {
    current_ = std::move(following_);
    following_ = RingPair();
}

void afterglow_stream::mark_read(const afterglow_frame &frame) {
    if (frame.index < next_)
        return;
    if (read_any_)
        skipped_ += frame.index - next_;
    read_any_ = true;
    next_ = frame.index + 1;
    last_ = frame;
}

template <class Read>
int afterglow_stream::latest(Read read) {
    const int nothing = nothing_new(); // before the look at head: what is there then is all
    for (int attempt = 0; attempt < most_attempts && has_new(); ++attempt) {
        if (follows())
            follow();
        afterglow_frame frame{};
        const ReadResult result = read(current_.head() - 1, frame);
        if (result == ReadResult::damaged)
            return -EBADMSG;
        if (result == ReadResult::whole) {
            mark_read(frame);
            return 0;
        }
    }
    return nothing;
}

int afterglow_stream::read_latest(afterglow_frame &frame,
                                  std::span<const afterglow_buffer> buffers) {
    return latest([&](std::uint64_t index, afterglow_frame &read) {
        const ReadResult result = current_.copy(index, read, buffers);
        frame = read;
        return result;
    });
}

int afterglow_stream::peek_latest(afterglow_frame &frame, std::span<afterglow_view> views) {
    return latest([&](std::uint64_t index, afterglow_frame &read) {
        const ReadResult result = current_.peek(index, read, views, peeked_);
        if (result != ReadResult::whole)
            peeked_ = {};
        frame = read;
        return result;
    });
}

int afterglow_stream::read(std::uint64_t index, afterglow_frame &frame,
                           std::span<const afterglow_buffer> buffers) {
    const int nothing = nothing_new();
    if (!is_open())
        return nothing;
    if (index < begin_)
        return -ESTALE;
    if (follows() && index >= following_.first())
        follow();
    if (index >= current_.head())
        return follows() ? -ESTALE : nothing; // between both memories: the stream was late
    switch (current_.copy(index, frame, buffers)) {
    case ReadResult::whole:
        mark_read(frame);
        return 0;
    case ReadResult::overwritten:
        return -ESTALE;
    default:
        return -EBADMSG;
    }
}
