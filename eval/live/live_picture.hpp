// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rgb.hpp"
#include "eval/live/live_scorer.hpp"

namespace afterglow {

/// Four panels: the image, the measured map, the estimate made from it, and the estimate's error,
/// each with a line of text.
Image<Rgb> live_picture(const LiveExample &example);

} // namespace afterglow
