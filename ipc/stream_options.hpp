// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace afterglow {

/// What a stream is asked for besides depth.
struct StreamOptions {
    /// Of a stream that wants few frames.
    static constexpr std::chrono::milliseconds longest_interval{1000};

    bool images = false;
    bool confidence = false;
    /// How often the stream wants a frame, at least; 0: of every image.
    std::chrono::milliseconds interval{0};
};

} // namespace afterglow
