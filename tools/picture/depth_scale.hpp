// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/picture/depth_colors.hpp"

namespace afterglow {

/// A vertical colour bar `height` pixels high, with the depths in metres that its colours stand
/// for; near is at the top. Without labels where `range` is that of a map without depth.
Image<Rgb> depth_scale(const DepthRange &range, int height);

} // namespace afterglow
