// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/frame_stamp.hpp"

namespace afterglow {
namespace {

/// How old a stream's first frame can be when it is received: longer than the longest exposures and
/// pipelines.
constexpr std::int64_t oldest_ns = 2'000'000'000;

} // namespace

std::optional<std::int64_t> exposure_begin(const FrameStamp &frame, std::int64_t period_ns,
                                           std::int64_t furthest_ahead_ns) {
    const bool waited = frame.previous_ns && frame.stamp_ns > *frame.previous_ns;
    if ((frame.stamp_ns < frame.arrival_ns - oldest_ns && !waited) ||
        frame.stamp_ns > frame.arrival_ns + furthest_ahead_ns)
        return std::nullopt;
    return frame.begins_exposure ? frame.stamp_ns : frame.stamp_ns - period_ns;
}

} // namespace afterglow
