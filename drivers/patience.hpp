// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace afterglow {

/// How long a camera may give nothing before it counts as stuck. USB cameras take a second or two
/// from sleep to their first image.
struct Patience {
    std::chrono::nanoseconds first_frame = std::chrono::seconds(3);
    std::chrono::nanoseconds next_frame = std::chrono::seconds(1);

    static constexpr Patience endless() { return {std::chrono::years(1), std::chrono::years(1)}; }
};

} // namespace afterglow
