// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/v4l2_time.hpp"
#include "tests/catch.hpp"

#include <linux/videodev2.h>

#include <cstdint>

using afterglow::v4l2::FrameClock;
using afterglow::v4l2::FrameCount;

namespace {

constexpr std::int64_t second = 1'000'000'000;
constexpr std::int64_t period = 33'333'333;
constexpr std::uint32_t monotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;

v4l2_buffer stamped(std::int64_t t_ns, std::uint32_t flags) {
    v4l2_buffer buffer = {};
    buffer.timestamp.tv_sec = t_ns / second;
    buffer.timestamp.tv_usec = t_ns % second / 1000;
    buffer.flags = flags;
    return buffer;
}

} // namespace

TEST_CASE("V4L2 frame numbers start at 0 whatever the driver's first") {
    FrameCount count;
    CHECK(count.next(17) == 0);
    CHECK(count.next(18) == 1);
}

TEST_CASE("a gap in V4L2 frame numbers is kept") {
    FrameCount count;
    count.next(5);
    CHECK(count.next(9) == 4);
}

TEST_CASE("V4L2 frame numbers continue when the driver's 32 bits wrap") {
    FrameCount count;
    count.next(0xffff'fffe);
    CHECK(count.next(0xffff'ffff) == 1);
    CHECK(count.next(1) == 3);
}

TEST_CASE("V4L2 frame numbers rise although the driver's repeat or decrease") {
    FrameCount count;
    count.next(0);
    CHECK(count.next(0) == 1);
    CHECK(count.next(0xffff'ffff) == 2);
}

TEST_CASE("a V4L2 timestamp of the exposure's start is the capture time") {
    FrameClock clock(period);
    const auto buffer = stamped(100 * second, monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE);
    CHECK(clock.capture_time(buffer, 100 * second + 40'000'000) == 100 * second);
}

TEST_CASE("a V4L2 timestamp of the frame's end is set back by one frame") {
    FrameClock clock(period);
    const auto buffer = stamped(100 * second, monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_EOF);
    CHECK(clock.capture_time(buffer, 100 * second + 1'000'000) == 100 * second - period);
}

TEST_CASE("a V4L2 timestamp one frame ahead of its arrival is accepted") {
    FrameClock clock(period);
    const auto buffer = stamped(100 * second + 32'000'000, monotonic);
    CHECK(clock.capture_time(buffer, 100 * second) == 100 * second + 32'000'000 - period);
}

TEST_CASE("a V4L2 timestamp of another clock is replaced by the arrival time") {
    FrameClock clock(period);
    const auto buffer = stamped(100 * second, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN);
    CHECK(clock.capture_time(buffer, 100 * second) == 100 * second - period);
    const auto copied = stamped(100 * second, V4L2_BUF_FLAG_TIMESTAMP_COPY);
    CHECK(FrameClock(period).capture_time(copied, 101 * second) == 101 * second - period);
}

TEST_CASE("after one impossible V4L2 timestamp the stream uses arrival times") {
    FrameClock clock(period);
    const auto flags = monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    CHECK(clock.capture_time(stamped(100 * second, flags), 100 * second) == 100 * second);
    // Wrapped: long past.
    CHECK(clock.capture_time(stamped(0, flags), 101 * second) == 101 * second - period);
    CHECK(clock.capture_time(stamped(102 * second, flags), 102 * second) == 102 * second - period);
}

TEST_CASE("V4L2 frames that waited for their reader keep their capture times") {
    FrameClock clock(period);
    const auto flags = monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    const std::int64_t begun = 100 * second, back = begun + 20 * second;
    CHECK(clock.capture_time(stamped(begun, flags), begun) == begun);
    // What the driver's queue has held since, and what comes after it.
    for (const std::int64_t waited : {begun + second, begun + 2 * second, begun + 3 * second})
        CHECK(clock.capture_time(stamped(waited, flags), back) == waited);
    CHECK(clock.capture_time(stamped(back, flags), back) == back);
}

TEST_CASE("the first V4L2 frame of a stream may have waited since the stream's start") {
    const auto flags = monotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    const std::int64_t started = 100 * second, back = started + 20 * second;
    FrameClock clock(period, started);
    CHECK(clock.capture_time(stamped(started + second, flags), back) == started + second);
    CHECK(clock.capture_time(stamped(back, flags), back) == back);
    FrameClock wrong(period, started); // another clock, long past
    CHECK(wrong.capture_time(stamped(5 * second, flags), back) == back - period);
}

TEST_CASE("a V4L2 timestamp in the far future is replaced by the arrival time") {
    FrameClock clock(period);
    const auto buffer = stamped(4'294'967'290 * second, monotonic);
    CHECK(clock.capture_time(buffer, 100 * second) == 100 * second - period);
}
