// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "drivers/v4l2/negotiate.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow::v4l2 {

/// What a pixel of a V4L2 format is in memory.
enum class Samples : std::uint8_t {
    words,   ///< a little-endian word of 16 bits, of which some may be 0
    halves,  ///< a byte, two of which are a little-endian word
    doubles, ///< two words, all first ones of a frame before all second ones
    bytes,   ///< a number of 8 bits
    nibbles, ///< a number of 4 bits; the first one is the lower
    mipi10,  ///< of 10 bits: four upper bytes, and a fifth with the rest of all
    mipi12,  ///< of 12 bits: two upper bytes, and a third with the rest of both
};
int bits_of(Samples samples);

/// The rows of a frame as little-endian words of 16 bits.
class WordRows {
public:
    /// `rows` rows of `words` bytes each, twice as many as words, are in a frame. Errors: frames
    /// of this layout do not hold that.
    static Result<WordRows> make(const FrameLayout &frame, Samples samples, std::size_t row_bytes,
                                 int rows);

    /// True if `bytes` end before the last row does.
    bool is_short(std::size_t bytes) const { return bytes < needed_; }
    /// Row `v` of a frame that is not short; valid until the next call. Allocates nothing.
    const std::uint8_t *row(std::span<const std::uint8_t> bytes, int v);

private:
    Samples samples_ = Samples::words;
    std::size_t advance_ = 0; ///< bytes from row to row
    std::size_t needed_ = 0;
    std::vector<std::uint8_t> words_; ///< an unpacked row; empty for samples that are words
};

} // namespace afterglow::v4l2
