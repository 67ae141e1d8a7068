// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rgb.hpp"
#include "eval/experiments/results.hpp"
#include "tools/picture/depth_colors.hpp"

#include <string>

namespace afterglow {

/// A depth map in colours, with the scale that explains them.
Picture depth_picture(const std::string &group, const std::string &caption, DepthView depth,
                      const DepthRange &range);

/// A picture as a `data:` address of a PNG file, at most 320 pixels wide. Empty where there is no
/// memory for it.
std::string png_data(const Image<Rgb> &picture);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

} // namespace afterglow
