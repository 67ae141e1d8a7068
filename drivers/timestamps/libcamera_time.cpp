// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/libcamera_time.hpp"

#include <initializer_list>
#include <time.h>

namespace afterglow::libcam {
namespace {

/// Clocks that differ by less than this are one.
constexpr std::int64_t furthest_ahead_ns = 1'000'000;

std::int64_t clock_ns(clockid_t clock) {
    timespec time = {};
    ::clock_gettime(clock, &time);
    return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

} // namespace

std::int64_t capture_time(const FrameStamp &frame, std::int64_t period_ns, std::int64_t asleep_ns) {
    for (const std::int64_t stamp_ns : {frame.stamp_ns, frame.stamp_ns - asleep_ns}) {
        const FrameStamp candidate = {stamp_ns, frame.begins_exposure, frame.arrival_ns};
        if (const auto begin_ns = exposure_begin(candidate, period_ns, furthest_ahead_ns))
            return *begin_ns;
    }
    return frame.arrival_ns - period_ns;
}

std::int64_t time_asleep_ns() {
    const std::int64_t monotonic_ns = clock_ns(CLOCK_MONOTONIC);
    return clock_ns(CLOCK_BOOTTIME) - monotonic_ns;
}

} // namespace afterglow::libcam
