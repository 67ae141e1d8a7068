// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace afterglow {

/// A PNG file in memory, decoded in two steps so that the caller can look at the size before any
/// pixel is made room for. The sentences of its errors do not name the file. Every row is given as
/// a pointer to its first byte.
class PngDecoder {
public:
    explicit PngDecoder(std::string_view bytes); ///< which must outlive the decoder
    ~PngDecoder();

    /// Reads up to the pixels, once and first. Sides above `max_side` pixels are refused.
    Status read_header(int max_side);
    int width() const { return width_; }
    int height() const { return height_; }
    bool is_grey() const; ///< one number for a pixel, and not three
    int bits() const;     ///< of each number

    /// Reads the pixels, once and last, as 8 bits a number: one for a pixel where is_grey(),
    /// otherwise red, green and blue. Deeper numbers are rounded, transparency is dropped.
    Status read_rows8(std::vector<std::uint8_t *> rows);
    /// The same of a file with 16 bits and is_grey(), in this machine's byte order.
    Status read_rows16(std::vector<std::uint8_t *> rows);

private:
    Status read_rows(std::vector<std::uint8_t *> rows, std::size_t row_bytes);

    struct Library;
    std::unique_ptr<Library> library_;
    int width_ = 0;
    int height_ = 0;
};

/// Pixels as PNG has them: 8 or 16 bits a number, 1 or 3 numbers for a pixel.
struct PngLayout {
    int width;
    int height;
    int bits;
    bool is_grey;
};

/// Writes rows (16 bits in this machine's byte order) to an open file.
Status encode_png(std::FILE *file, const PngLayout &layout,
                  std::span<const std::uint8_t *const> rows);

} // namespace afterglow
