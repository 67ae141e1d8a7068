// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/stream.hpp"

#include "core/base/printable.hpp"
#include "drivers/v4l2/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <poll.h>
#include <utility>

namespace afterglow::v4l2 {
namespace {

/// A frame without a believed time stamp is used if it waited in the driver's queue for at most
/// this, or two frame periods if that is more.
constexpr std::int64_t longest_wait_ns = 100'000'000;

} // namespace

Result<FrameLayout> Stream::start() {
    stop();
    Result<UniqueFd> fd = open_device(calls_, request_.device);
    if (!fd)
        return fd.error();
    Result<FrameLayout> layout = negotiate(calls_, fd->get(), request_);
    if (!layout)
        return layout;
    forbid_slow_exposure(calls_, fd->get());
    Result<BufferQueue> queue =
        BufferQueue::start(calls_, fd->get(), layout->buffer_type, request_.device);
    if (!queue)
        return queue.error();

    fd_ = std::move(*fd);
    queue_.emplace(*std::move(queue));
    begun_ = false;
    count_ = FrameCount();
    clock_ = FrameClock(layout->period_ns, calls_.now_ns());
    filled_after_ns_ = calls_.now_ns();
    period_ns_ = layout->period_ns;
    allow(timeouts_.first_frame);
    return layout;
}

void Stream::stop() {
    held_.reset();
    queue_.reset();
    fd_ = UniqueFd();
}

Capture Stream::next(RawFrame &frame, std::chrono::nanoseconds timeout) {
    assert(queue_ && !held_);
    const std::int64_t deadline_ns = calls_.now_ns() + timeout.count();
    v4l2_buffer buffer = {};
    for (;;) {
        if (queue_->dequeue(buffer)) {
            if (std::exchange(begun_, true)) {
                const Capture capture = accept(buffer, frame);
                if (capture != Capture::frame || has_time())
                    return capture;
                release();
            } else if (!queue_->queue(buffer.index)) {
                return lost(errno);
            }
        } else if (errno != EAGAIN) {
            return lost(errno);
        } else {
            filled_after_ns_ = calls_.now_ns();
            if (const std::optional<Capture> end = wait(deadline_ns))
                return *end;
        }
    }
}

std::optional<Capture> Stream::wait(std::int64_t deadline_ns) {
    const std::int64_t now_ns = calls_.now_ns();
    if (now_ns >= stuck_at_ns_)
        return lost(ETIMEDOUT);
    if (now_ns >= deadline_ns)
        return Capture::none;
    const std::int64_t until_ns = std::min(deadline_ns, stuck_at_ns_);
    const int events = calls_.poll(fd_.get(), std::chrono::nanoseconds(until_ns - now_ns));
    // An error without a frame: dequeuing says which, unless the driver has just stopped.
    v4l2_buffer buffer = {};
    if ((events & (POLLERR | POLLHUP)) != 0 && (events & POLLIN) == 0)
        return lost(queue_->dequeue(buffer) || errno == EAGAIN ? EIO : errno);
    return std::nullopt;
}

Capture Stream::accept(const v4l2_buffer &first, RawFrame &frame) {
    v4l2_buffer buffer = first;
    std::uint64_t sequence = count_.next(buffer.sequence);
    v4l2_buffer newer = {};
    while (backlog_ == Backlog::newest && queue_->dequeue(newer)) {
        if (!queue_->queue(buffer.index))
            return lost(errno);
        buffer = newer;
        sequence = count_.next(buffer.sequence);
    }
    held_ = buffer.index;
    allow(timeouts_.next_frame);
    if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) { // its stamp may be as wrong
        release();
        return damaged("the driver marks its data as corrupt");
    }
    frame = {queue_->bytes(buffer), clock_.capture_time(buffer, calls_.now_ns()), sequence};
    return Capture::frame;
}

/// Whether the time of the frame just dequeued is known. Without a believed time stamp it is the
/// time of dequeuing, which is wrong for a frame that has waited in the driver's queue.
bool Stream::has_time() {
    const std::int64_t now_ns = calls_.now_ns();
    if (backlog_ == Backlog::in_order && !clock_.believes_stamps() &&
        now_ns - filled_after_ns_ > std::max(longest_wait_ns, 2 * period_ns_))
        return false;
    filled_after_ns_ = now_ns; // frames behind this one arrived after it
    return true;
}

void Stream::allow(std::chrono::nanoseconds silence) {
    stuck_at_ns_ = calls_.now_ns() + Timeouts::with(silence, period_ns_).count();
}

void Stream::release() {
    // A driver that refuses its own buffer has stopped, and says so when the next one is awaited.
    queue_->queue(*held_);
    held_.reset();
}

Capture Stream::damaged(std::string_view why) {
    problem_ =
        fmt::format("an image of the camera '{}' is dropped: {}", printable(request_.device), why);
    return Capture::damaged;
}

Capture Stream::lost(int code) {
    switch (code) {
    case ENODEV:
        problem_ = fmt::format("the camera '{}' was unplugged", printable(request_.device));
        break;
    case ETIMEDOUT:
        problem_ = fmt::format("the camera '{}' gives no images", printable(request_.device));
        break;
    default:
        problem_ = fmt::format("the camera '{}' stopped: {}", printable(request_.device),
                               std::strerror(code));
        break;
    }
    return Capture::lost;
}

} // namespace afterglow::v4l2
