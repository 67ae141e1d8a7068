// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <ctime>

namespace afterglow {

/// The time of a clock as clock_gettime() takes it, nanoseconds. Real-time safe.
inline std::int64_t clock_ns(clockid_t clock) {
    timespec time{};
    ::clock_gettime(clock, &time);
    return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}
/// CLOCK_MONOTONIC, by which frames are stamped, nanoseconds. Real-time safe.
inline std::int64_t monotonic_ns() {
    return clock_ns(CLOCK_MONOTONIC);
}

} // namespace afterglow
