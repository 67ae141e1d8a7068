// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/residuals.hpp"

#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// The readings of a depth map that lie on the board, where `board_to_tof` is about its pose: those
/// seen within its outline (a tenth of its size left out all around) and no further than `gate_m`
/// from its plane. At most `most` of them, evenly spread.
std::vector<DepthReading> readings_on_board(const Board &board, const Pose &board_to_tof,
                                            const CameraModel &tof, bool range_along_ray,
                                            DepthView depth, double gate_m, int most = 200);

/// What depth says of boards whose poses are known.
struct DepthCheck {
    bool range_along_ray = false; ///< the reading of the numbers that fits better
    double scale = 1;             ///< measured by expected, median
    double noise_m = 0;           ///< about that
};

struct SeenBoard {
    const DepthMap *depth;
    Pose board_to_tof;
};
/// Nothing where there are no readings on the boards.
std::optional<DepthCheck> check_depth(const Board &board, std::span<const SeenBoard> seen,
                                      const CameraModel &tof);

} // namespace afterglow
