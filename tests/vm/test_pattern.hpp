// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>

namespace afterglow::vm {

/// Byte of the pixels of row v of image `index`: every row, and every image of 256, differs, so
/// that rows that are missing, or of another image, are noticed.
inline std::uint8_t pattern(std::uint32_t index, int v) {
    return static_cast<std::uint8_t>(index + 3 * static_cast<std::uint32_t>(v));
}
/// What stands beside it in pixels of two bytes: no colour, or the upper half of a depth.
inline constexpr std::uint8_t other_byte = 128;

/// True if every pixel is that of one and the same image.
template <class Pixel>
bool is_whole(ImageView<const Pixel> image) {
    const int upper = sizeof(Pixel) == 2 ? other_byte << 8 : 0;
    const std::uint32_t index = image(0, 0);
    for (int v = 0; v < image.height(); ++v) {
        for (int u = 0; u < image.width(); ++u) {
            if (image(u, v) != upper + pattern(index, v))
                return false;
        }
    }
    return true;
}

} // namespace afterglow::vm
