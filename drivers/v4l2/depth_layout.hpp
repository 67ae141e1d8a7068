// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace afterglow {

/// Where the frames of a depth node have the amplitude of the light, or a confidence. Words are of
/// 16 bits, little-endian.
enum class DepthLayout : std::uint8_t {
    depth,                      ///< nowhere: a word of depth for each pixel
    amplitude_bits,             ///< in other bits of the same word
    amplitude_words,            ///< in every second word of a row
    amplitude_words_first,      ///< the same, but the amplitude of a pixel is before its depth
    amplitude_after_confidence, ///< five bytes a pixel: a word of depth, a byte, a word of
                                ///< amplitude
    amplitude_rows,             ///< in every second row
    amplitude_below,            ///< in as many rows below those of depth
    amplitude_above,            ///< in as many rows above those of depth
};

/// How the frames of a depth node hold maps.
struct DepthPacking {
    DepthLayout layout = DepthLayout::depth;
    int depth_mask = 0xffff;     ///< adjacent bits of a word of depth that are used; others are cut
    int amplitude_mask = 0xffff; ///< the same of a word of amplitude
    int skip_rows_top = 0;       ///< rows that are no part of the map: metadata
    int skip_rows_bottom = 0;
    /// Pixels in a row of the node, where that is not what a row of the map takes: the bytes of a
    /// map, one after the other, are then cut into rows of this length. 0 = what it takes.
    int node_width = 0;
};

} // namespace afterglow
