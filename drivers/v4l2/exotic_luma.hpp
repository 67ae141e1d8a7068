// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/v4l2/luma_reader.hpp"

namespace afterglow::v4l2 {

/// RGB, Bayer and packed formats of old webcams, which libv4lconvert knows; none where it was not
/// there at build time.
std::span<const std::uint32_t> exotic_luma_formats();
/// `layout.fourcc` is one of them.
LumaReader make_exotic_reader(const FrameLayout &layout, int fd);

} // namespace afterglow::v4l2
