// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/error/local_errors.hpp"

#include <cstdint>

namespace afterglow {

/// Pixels of a composed map (millimetres, 0 = none) with their confidences, and the same pixels
/// measured.
struct ComparedPixels {
    ImageView<const std::uint16_t> composed;
    ImageView<const std::uint8_t> confidence;
    ImageView<const std::uint16_t> measured;
};
/// Compares those at even columns and rows that have depth in both maps. What a confidence promises
/// counts without the share `misplaced`, and as confidence_step at least. Real-time safe.
ComparedErrors compare_errors(const ComparedPixels &pixels, float misplaced);

} // namespace afterglow
