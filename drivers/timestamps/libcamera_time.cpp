// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/libcamera_time.hpp"

#include <initializer_list>
#include <time.h>

namespace afterglow::libcam {
namespace {

/// How old a frame can be when it is complete: longer than the longest exposures and pipelines.
constexpr std::int64_t oldest_ns = 2'000'000'000;
/// Clocks that differ by less than this are one.
constexpr std::int64_t furthest_ahead_ns = 1'000'000;

std::int64_t clock_ns(clockid_t clock) {
    timespec time = {};
    ::clock_gettime(clock, &time);
    return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

bool has_just_been(std::int64_t t_ns, std::int64_t now_ns) {
    return t_ns > now_ns - oldest_ns && t_ns <= now_ns + furthest_ahead_ns;
}

} // namespace

std::int64_t capture_time(const Stamp &stamp, std::int64_t period_ns, std::int64_t asleep_ns) {
    const std::int64_t set_back_ns = stamp.begins_exposure ? 0 : period_ns;
    for (const std::int64_t t_ns : {stamp.stamp_ns, stamp.stamp_ns - asleep_ns}) {
        if (has_just_been(t_ns, stamp.arrival_ns))
            return t_ns - set_back_ns;
    }
    return stamp.arrival_ns - period_ns;
}

std::int64_t time_asleep_ns() {
    const std::int64_t monotonic_ns = clock_ns(CLOCK_MONOTONIC);
    return clock_ns(CLOCK_BOOTTIME) - monotonic_ns;
}

} // namespace afterglow::libcam
