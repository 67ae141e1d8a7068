// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace afterglow {

/// What a driver says of when a frame was exposed; nanoseconds.
struct FrameStamp {
    std::int64_t stamp_ns = 0;
    bool begins_exposure = false; ///< the stamp is of the exposure's begin; otherwise of its end
    std::int64_t arrival_ns = 0;  ///< when the frame was received, CLOCK_MONOTONIC
    /// The stamp of the stream's frame before, if there is one.
    std::optional<std::int64_t> previous_ns = std::nullopt;
};

/// When the exposure began, CLOCK_MONOTONIC; a stamp of the end is set back by one frame period.
/// Nothing when the stamp cannot be of CLOCK_MONOTONIC: it is more than `furthest_ahead_ns` later
/// than the arrival; or it is more than 2 s older, and not later than the frame before: a frame
/// that is may have waited for its reader, however long. Real-time safe.
std::optional<std::int64_t> exposure_begin(const FrameStamp &frame, std::int64_t period_ns,
                                           std::int64_t furthest_ahead_ns);

} // namespace afterglow
