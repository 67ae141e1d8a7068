// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "tools/calibrate/captures.hpp"
#include "tools/calibrate/rig_fit.hpp"

#include <span>
#include <string>

namespace afterglow {

/// Residuals are drawn so many times as long as they are.
inline constexpr double residual_magnification = 100;

/// Writes to a folder, which is made where it is missing:
///     color.png, tof.png     where corners were seen (green cells) and an arrow for the residual
///                            of each, residual_magnification times as long; tof.png where the
///                            amplitude shows the board
///     depth_on_color.png     the depth of the view in which the board is nearest, over its image
/// `views` are those of the fit and of `captures`.
Status write_report_pictures(const std::string &folder, const Captures &captures,
                             const Board &board, std::span<const BoardView> views,
                             const RigFit &fit);

/// `image` with what was found in it: the board's corners.
Status write_preview(const std::string &path, LumaView image, const Corners &corners);

} // namespace afterglow
