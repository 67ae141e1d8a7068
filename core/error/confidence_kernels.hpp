// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <bit>
#include <cstdint>

namespace afterglow {

/// A pixel's class: the distance of its point from the next depth edge, below class_layer, and in
/// which of several maps it lies.
constexpr int class_layer = 8;
/// Bins of depth by which confidences are told: four to an octave, as errors are shares of depth.
constexpr int depth_bins = 60;

constexpr int depth_bin(std::uint16_t millimetres) {
    const int octave = std::bit_width(millimetres) - 2; // the first ones have a millimetre a bin
    return octave <= 0 ? millimetres : 4 * octave + (millimetres >> (octave - 1)) % 4;
}
/// The least depth in a bin, millimetres. first_of_bin(depth_bins) is the end of the last bin.
constexpr int first_of_bin(int bin) {
    return bin < 4 ? bin : (4 + bin % 4) << (bin / 4 - 1);
}
/// In the middle of a bin, metres.
constexpr float middle_of_bin(int bin) {
    return 0.0005f * static_cast<float>(first_of_bin(bin) + first_of_bin(bin + 1));
}
static_assert(depth_bin(0xffff) == depth_bins - 1 && first_of_bin(depth_bins) == 0x10000);
/// Where a table has the confidence of a class and a bin: all edge distances of a bin are
/// neighbours, then come the next bin's, then the next layer's.
constexpr int place_in_table(int pixel_class, int bin) {
    const int layer = pixel_class / class_layer;
    return (layer * depth_bins + bin) * class_layer + pixel_class % class_layer;
}

/// Width, pixels, of the tiles for which JudgedPixels::places tells one place for all pixels.
constexpr int judged_tile_px = 16;
/// Instead of a place: a tile's pixels have several.
constexpr std::uint16_t places_differ = 0xffff;

/// Pixels that are given a confidence by their depth (millimetres, 0 = none) and class.
struct JudgedPixels {
    ImageView<const std::uint16_t> depth;
    ImageView<const std::uint8_t> classes;
    /// By tile: the place_in_table() of all of its pixels, or places_differ. May be empty.
    ImageView<const std::uint16_t> places = {};
    int tile_rows = 1; ///< rows of pixels in a tile
};
/// Confidences by class and bin (place_in_table()), but `less` lower; unknown_confidence at least,
/// where the tables have any.
struct Confidences {
    const std::uint8_t *table;       ///< 0 for class 0
    const std::uint8_t *other_table; ///< a second one, whose confidences are summed up only
    std::uint8_t less;
};
/// Over some pixels that have depth.
struct ConfidenceSum {
    std::uint64_t sum = 0; ///< of their confidences
    int pixels = 0;

    ConfidenceSum &operator+=(const ConfidenceSum &other) {
        sum += other.sum;
        pixels += other.pixels;
        return *this;
    }
    bool operator==(const ConfidenceSum &) const = default;
};
/// By each of both tables.
struct ConfidenceSums {
    ConfidenceSum by_table, by_other_table;
};
/// Looks up the confidences of the pixels that have depth, beginning with `first_bin` and the next;
/// others get none, their class is 0. Sums up one row in `summed_row`, from the first on; a tile's
/// rows are a multiple of it. Real-time safe.
ConfidenceSums look_up_confidences(const JudgedPixels &pixels, const Confidences &of, int first_bin,
                                   int summed_row, ImageView<std::uint8_t> confidence);

/// Of a row over which a measured one was laid.
struct Overlaid {
    int measured = 0;      ///< pixels that are measured
    ConfidenceSum covered; ///< over the pixels that have depth now
};
/// Pixels of a row that are measured (millimetres, 0 = none) get that depth and
/// measured_confidence. Real-time safe.
Overlaid lay_over(const std::uint16_t *measured, int count, std::uint16_t *depth,
                  std::uint8_t *confidence);

} // namespace afterglow
