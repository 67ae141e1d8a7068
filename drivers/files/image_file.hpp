// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rgb.hpp"

#include <cstdint>
#include <string>

namespace afterglow {

// Files are untrusted: whatever is in them, the answer is pixels or an Error whose sentence begins
// with the file's name. A file that is cut short or damaged anywhere is refused as a whole, and so
// are images larger than max_image_side. Not real-time safe; any thread.

inline constexpr int max_image_side = 8192; ///< pixels

/// 0.299 R + 0.587 G + 0.114 B, rounded.
constexpr std::uint8_t luma_of(const Rgb &pixel) {
    return static_cast<std::uint8_t>(
        (299 * pixel.red + 587 * pixel.green + 114 * pixel.blue + 500) / 1000);
}

/// Reads a PNG or JPEG file as luma; colour by luma_of().
Result<Luma> read_luma(const std::string &path);
/// The same into memory that is there already, and whose size the image must have. On failure the
/// pixels are undefined.
Status read_luma(const std::string &path, ImageView<std::uint8_t> luma);

/// Reads a 16-bit grey PNG file: raw numbers, in whatever unit the file keeps.
Result<Image<std::uint16_t>> read_grey16(const std::string &path);
/// The same into memory that is there already, and whose size the image must have. On failure the
/// pixels are undefined.
Status read_grey16(const std::string &path, ImageView<std::uint16_t> pixels);

// Written as an OutputFile: under its name there is the old file or the new one, as a whole.

Status write_png(const std::string &path, LumaView luma);
Status write_png(const std::string &path, DepthView depth); ///< 16-bit grey
Status write_png(const std::string &path, ImageView<const Rgb> picture);

} // namespace afterglow
