// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace afterglow::libcam {

/// What is known of when a frame was exposed; nanoseconds.
struct Stamp {
    std::int64_t stamp_ns = 0;
    bool begins_exposure = false; ///< or else it ends the frame
    std::int64_t arrival_ns = 0;  ///< CLOCK_MONOTONIC
};

/// When the exposure began, CLOCK_MONOTONIC. libcamera says that its stamps are of CLOCK_BOOTTIME;
/// those of the kernel's drivers, which it hands on, are of CLOCK_MONOTONIC. The one by which a
/// stamp has just gone by is believed; if neither, arrival stands for the frame's end.
/// `asleep_ns`: how long the machine has slept, by which the two differ.
std::int64_t capture_time(const Stamp &stamp, std::int64_t period_ns, std::int64_t asleep_ns);

/// CLOCK_BOOTTIME - CLOCK_MONOTONIC.
std::int64_t time_asleep_ns();

} // namespace afterglow::libcam
