// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace afterglow::libcam {

/// The FourCCs of V4L2 whose luma can be read out of libcamera's buffers, the cheapest first: all
/// but those that libv4lconvert converts, for it wants a device of V4L2.
std::vector<std::uint32_t> readable_formats();

/// libcamera names formats as the kernel's display drivers do: with another code for grey ones.
std::uint32_t drm_code(std::uint32_t v4l2_code);
std::uint32_t v4l2_code(std::uint32_t drm_code);

} // namespace afterglow::libcam
