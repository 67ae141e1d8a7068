// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace afterglow {

/// How long a camera may be silent before it counts as lost: this long, and at least three frame
/// periods. USB cameras need one to two seconds to their first image.
struct Timeouts {
    std::chrono::nanoseconds first_frame = std::chrono::seconds(3);
    std::chrono::nanoseconds next_frame = std::chrono::seconds(1);

    static constexpr Timeouts endless() { return {std::chrono::years(1), std::chrono::years(1)}; }
    static std::chrono::nanoseconds with(std::chrono::nanoseconds silence, std::int64_t period_ns) {
        return std::max(silence, std::chrono::nanoseconds(3 * period_ns));
    }
};

} // namespace afterglow
