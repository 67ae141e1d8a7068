// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/alignment_template.hpp"
#include "core/base/camera.hpp"
#include "core/base/grey.hpp"

#include <span>

namespace afterglow {

/// Finds the pixel with the steepest gradient (central differences) of each column between two rows
/// of an image: the square of the gradient's length, grey values per pixel, and its row, the first
/// of several. 1 <= first_row < end_row < height; the outputs are as long as the image is wide, and
/// the first and last column's are left as they were. Real-time safe.
void find_steepest(GreyView image, int first_row, int end_row, std::span<float> steepness,
                   std::span<int> rows);

/// Works out what follows for the first `points.count` points from where they were found, their
/// depth, their grey value and the contrast: all other columns. `camera`: of the level. Whole
/// vectors are written. Real-time safe.
void complete_points(const FoundPoints &found, const Intrinsics &camera,
                     const TemplateOptions &options, TemplatePoints &points);

} // namespace afterglow
