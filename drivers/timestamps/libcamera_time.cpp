// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/libcamera_time.hpp"

#include "core/base/clock.hpp"

#include <initializer_list>
#include <time.h>

namespace afterglow::libcam {
namespace {

/// Clocks that differ by less than this are one.
constexpr std::int64_t furthest_ahead_ns = 1'000'000;

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
    const std::int64_t awake_ns = monotonic_ns();
    return clock_ns(CLOCK_BOOTTIME) - awake_ns;
}

} // namespace afterglow::libcam
