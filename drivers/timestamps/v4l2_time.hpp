// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

struct v4l2_buffer;

namespace afterglow::v4l2 {

/// Turns a driver's 32-bit frame numbers, which start anywhere and wrap, into a count from 0. A
/// number that does not rise (some drivers always give 0) counts as the next one.
class FrameCount {
public:
    std::uint64_t next(std::uint32_t number);

private:
    bool begun_ = false;
    std::uint32_t last_ = 0;
    std::uint64_t count_ = 0;
};

/// When the exposures of a stream's frames began, CLOCK_MONOTONIC, from the driver's stamps
/// (exposure_begin()). From the first stamp of another clock, or one that is impossible, on, the
/// stamps of this stream are ignored, and a frame's end is taken to be its arrival.
class FrameClock {
public:
    /// `started_ns`: CLOCK_MONOTONIC when the stream was started. A first frame with a later stamp
    /// is believed however old it is: it has waited for its reader.
    explicit FrameClock(std::int64_t period_ns = 0, std::optional<std::int64_t> started_ns = {})
        : period_ns_(period_ns), previous_ns_(started_ns) {}

    /// `now_ns`: CLOCK_MONOTONIC as the buffer was dequeued.
    std::int64_t capture_time(const v4l2_buffer &buffer, std::int64_t now_ns);
    bool believes_stamps() const { return stamps_believed_; }

private:
    std::int64_t period_ns_;
    std::optional<std::int64_t> previous_ns_; ///< the stamp of the frame before, or the start
    bool stamps_believed_ = true;
};

} // namespace afterglow::v4l2
