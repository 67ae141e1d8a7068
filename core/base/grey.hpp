// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>

namespace afterglow {

/// A grey value of 0 to 255, in steps of 1/256: means of up to 16 x 16 pixels are exact.
using Grey = std::uint16_t;
constexpr int grey_steps = 256;
/// Grey values per step.
constexpr float grey_step = 1.0f / grey_steps;

/// The grey value of the brightest place that a camera can show; brighter ones are shown alike.
constexpr float white = 255;
/// A grey value above this is taken for the mean of white pixels.
constexpr float nearly_white = 250;

using GreyImage = Image<Grey>;
using GreyView = ImageView<const Grey>;

} // namespace afterglow
