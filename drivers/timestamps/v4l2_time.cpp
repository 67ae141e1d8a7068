// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/v4l2_time.hpp"

#include "drivers/timestamps/frame_stamp.hpp"

#include <linux/videodev2.h>

#include <algorithm>

namespace afterglow::v4l2 {
namespace {

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
    const bool is_begin =
        (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    const bool is_monotonic =
        (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    const auto begin_ns = exposure_begin({stamp_ns, is_begin, now_ns, previous_ns_}, period_ns_,
                                         std::max(furthest_ahead_ns, period_ns_));
    previous_ns_ = stamp_ns;
    stamps_believed_ = stamps_believed_ && is_monotonic && begin_ns;
    return stamps_believed_ ? *begin_ns : now_ns - period_ns_;
}

} // namespace afterglow::v4l2
