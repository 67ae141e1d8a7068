// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

struct v4l2_buffer;

namespace afterglow::v4l2 {

/// Makes a driver's 32-bit frame numbers, which start anywhere and wrap, a count from 0. A number
/// that does not rise (some drivers give always 0) counts as the next.
class FrameCount {
public:
    std::uint64_t next(std::uint32_t number);

private:
    bool begun_ = false;
    std::uint32_t last_ = 0;
    std::uint64_t count_ = 0;
};

/// When a stream's frames were exposed, in CLOCK_MONOTONIC: the driver's stamp where it is one, of
/// a frame's end set back by a frame period. A stamp on another clock, or one that cannot be true,
/// ends the belief in the stamps of this stream; from then on arrival stands for the frame's end.
class FrameClock {
public:
    explicit FrameClock(std::int64_t period_ns = 0) : period_ns_(period_ns) {}

    /// `now_ns`: CLOCK_MONOTONIC as the buffer was dequeued.
    std::int64_t capture_time(const v4l2_buffer &buffer, std::int64_t now_ns);

private:
    std::int64_t period_ns_;
    bool stamps_believed_ = true;
};

} // namespace afterglow::v4l2
