// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/v4l2_time.hpp"

#include <linux/videodev2.h>

#include <algorithm>

namespace afterglow::v4l2 {
namespace {

/// How old a frame can be when it is dequeued: a full queue of a slow reader, and then some.
constexpr std::int64_t oldest_ns = 2'000'000'000;
/// Drivers that compute the stamp of a frame's end may put it into the future, but not further.
constexpr std::int64_t furthest_ahead_ns = 50'000'000;

} // namespace

std::uint64_t FrameCount::next(std::uint32_t number) {
    if (begun_) {
        const std::uint32_t step = number - last_; // modulo 2^32
        count_ += step == 0 || step > 1U << 31 ? 1 : step;
    }
    begun_ = true;
    last_ = number;
    return count_;
}

std::int64_t FrameClock::capture_time(const v4l2_buffer &buffer, std::int64_t now_ns) {
    const auto stamp_ns = static_cast<std::int64_t>(buffer.timestamp.tv_sec) * 1'000'000'000 +
                          static_cast<std::int64_t>(buffer.timestamp.tv_usec) * 1'000;
    const std::int64_t ahead_ns = std::max(furthest_ahead_ns, period_ns_);
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC ||
        stamp_ns < now_ns - oldest_ns || stamp_ns > now_ns + ahead_ns)
        stamps_believed_ = false;
    if (!stamps_believed_)
        return now_ns - period_ns_;
    const bool begin =
        (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    return begin ? stamp_ns : stamp_ns - period_ns_;
}

} // namespace afterglow::v4l2
