// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/timestamps/frame_stamp.hpp"

#include <cstdint>

namespace afterglow::libcam {

/// When the exposure began, CLOCK_MONOTONIC. libcamera documents its stamps as CLOCK_BOOTTIME, but
/// passes on those of the kernel's drivers, which are CLOCK_MONOTONIC. So the stamp is tried as
/// either, CLOCK_MONOTONIC first (exposure_begin()); if it can be neither, the frame's end is taken
/// to be its arrival. `asleep_ns`: CLOCK_BOOTTIME - CLOCK_MONOTONIC, time_asleep_ns().
std::int64_t capture_time(const FrameStamp &frame, std::int64_t period_ns, std::int64_t asleep_ns);

/// CLOCK_BOOTTIME - CLOCK_MONOTONIC.
std::int64_t time_asleep_ns();

} // namespace afterglow::libcam
