// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace afterglow::bench {

/// Begins a file of decoded frames, all numbers little endian. `frames` times follow: an int64
/// time stamp in nanoseconds, the luma, and the depth in uint16 millimetres, both row by row.
struct FramesHeader {
    double fx, fy, cx, cy; ///< pixels
    std::int32_t width, height;
    std::int64_t frames;

    std::size_t pixels() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    std::size_t frame_bytes() const { return sizeof(std::int64_t) + 3 * pixels(); }
};

} // namespace afterglow::bench
