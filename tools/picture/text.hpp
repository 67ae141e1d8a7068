// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rgb.hpp"

#include <string_view>

namespace afterglow {

/// Height of a line and advance of a character at scale 1, pixels.
inline constexpr int text_height = 9;
inline constexpr int text_advance = 6;

/// Writes lower-case letters, digits and . , : % - into a picture, each pixel of the font `scale`
/// pixels wide. (u, v) is the top left of the first character; what falls outside is cut, unknown
/// characters are blank.
void draw_text(ImageView<Rgb> picture, int u, int v, std::string_view text, Rgb color, int scale);

} // namespace afterglow
