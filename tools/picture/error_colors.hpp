// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rgb.hpp"

namespace afterglow {

/// Relative errors from here on are shown alike, percent.
inline constexpr double largest_error_shown = 5;

/// From dark blue (no error) over orange to pale yellow (`largest_error_shown`).
Rgb error_color(double percent);

/// The relative error of every pixel in colours; almost black where either map has no depth. Both
/// maps have one size.
Image<Rgb> color_error(DepthView estimate, DepthView truth);

} // namespace afterglow
