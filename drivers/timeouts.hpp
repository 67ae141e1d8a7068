// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace afterglow {

/// How long a camera may give nothing before it counts as stuck: so long, and in any case three of
/// its frames. USB cameras take a second or two from sleep to their first image.
struct Timeouts {
    std::chrono::nanoseconds first_frame = std::chrono::seconds(3);
    std::chrono::nanoseconds next_frame = std::chrono::seconds(1);

    static constexpr Timeouts endless() { return {std::chrono::years(1), std::chrono::years(1)}; }
    static std::chrono::nanoseconds with(std::chrono::nanoseconds silence, std::int64_t period_ns) {
        return std::max(silence, std::chrono::nanoseconds(3 * period_ns));
    }
};

} // namespace afterglow
