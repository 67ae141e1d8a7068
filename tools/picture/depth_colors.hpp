// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rgb.hpp"

#include <cstdint>
#include <span>

namespace afterglow {

/// The colour at `place`, 0 to 1, of a scale of equally spaced stops. Values outside are clamped.
Rgb interpolate(std::span<const Rgb> stops, double place);

/// Warm is near and cold is far: red at 0, over yellow, green and blue, to violet at 1. Values
/// outside are clamped.
Rgb color_scale(double place);

/// The colour of a depth in millimetres, of which `near_mm` and `far_mm` are the ends of the
/// scale; almost black where there is no depth.
Rgb depth_color(std::uint16_t depth_mm, double near_mm, double far_mm);

struct DepthRange {
    double near_mm = 0;
    double far_mm = 1;
};

/// The scale that shows a map best: from its 2nd to its 98th percentile, holes not counted.
DepthRange depth_range(DepthView depth);

/// The whole map in colours.
Image<Rgb> color_depth(DepthView depth, const DepthRange &range);

} // namespace afterglow
