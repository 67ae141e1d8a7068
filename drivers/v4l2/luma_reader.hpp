// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "drivers/v4l2/negotiate.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

namespace afterglow::v4l2 {

/// Converts a frame's bytes to pixels. Returns why that failed (too few bytes, no valid picture),
/// or
/// "". Allocates nothing, except in a library that decompresses.
template <class Pixel>
using PixelReader =
    std::function<std::string_view(std::span<const std::uint8_t> bytes, ImageView<Pixel> pixels)>;
using LumaReader = PixelReader<std::uint8_t>;
using DepthReader = PixelReader<std::uint16_t>;

/// The FourCCs that have a luma reader, that whose luma costs least to read first.
std::span<const std::uint32_t> luma_formats();
/// `layout.fourcc` is one of them; `fd` is the device's.
LumaReader make_luma_reader(const FrameLayout &layout, int fd);

/// The unit and the invalid value of a depth format.
struct DepthScale {
    double mm_per_unit = 1;
    int invalid = 0;
};
/// The FourCCs that have a depth reader, the likeliest to be depth first.
std::span<const std::uint32_t> depth_formats();
/// `layout.fourcc` is one of them.
DepthReader make_depth_reader(const FrameLayout &layout, const DepthScale &scale);

/// True if `bytes` end before the last row of pixels does.
bool is_short(const FrameLayout &layout, std::size_t row_bytes, std::size_t bytes);

} // namespace afterglow::v4l2
