// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace afterglow {

/// What a stream is asked for besides depth.
struct StreamOptions {
    /// The most that `interval` may be.
    static constexpr std::chrono::milliseconds longest_interval{1000};

    bool images = false;
    bool confidence = false;
    /// The longest time between two frames that the stream accepts; 0: a frame of every image.
    std::chrono::milliseconds interval{0};
};

} // namespace afterglow
