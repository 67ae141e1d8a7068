// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/v4l2/negotiate.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

namespace afterglow::v4l2 {

/// Converts a frame's bytes to luma. Returns why that failed (too few bytes, no valid picture), or
/// "". Allocates nothing, except in a library that decompresses.
using LumaReader = std::function<std::string_view(std::span<const std::uint8_t> bytes,
                                                  ImageView<std::uint8_t> luma)>;

/// The FourCCs that have a luma reader, that whose luma costs least to read first.
std::span<const std::uint32_t> luma_formats();
/// `layout.fourcc` is one of them; `fd` is the device's.
LumaReader make_luma_reader(const FrameLayout &layout, int fd);

/// True if `bytes` end before the last row of pixels does.
bool is_short(const FrameLayout &layout, std::size_t row_bytes, std::size_t bytes);

} // namespace afterglow::v4l2
