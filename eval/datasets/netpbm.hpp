// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"

#include <bit>
#include <cstdint>
#include <string>

namespace afterglow {

// Binary Netpbm files. As untrusted as those of drivers/files/image_file.hpp, and refused like
// them: with an Error whose sentence begins with the file's name.

/// Reads a PPM file (P6, 8 bits) as luma, by luma_of().
Result<Luma> read_ppm_luma(const std::string &path);

/// Reads a PGM file (P5) with 16-bit numbers. The format has them in big-endian order; there are
/// recordings which have not.
Result<Image<std::uint16_t>> read_pgm16(const std::string &path, std::endian order);

} // namespace afterglow
