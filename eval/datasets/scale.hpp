// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

namespace afterglow {

/// The middle of an image, as large as can be with the proportions of `width` x `height`, shrunk
/// to that size: each pixel is the average of the area that it covers. `image` is no smaller.
Luma cropped_and_shrunk(LumaView image, int width, int height);

} // namespace afterglow
