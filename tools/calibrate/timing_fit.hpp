// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "tools/calibrate/board.hpp"
#include "tools/calibrate/find_board.hpp"

#include <span>

namespace afterglow {

/// The longest time between reading the first and the last row of an image that is looked for.
inline constexpr double longest_readout_s = 0.05;
/// The largest time between the clocks that is looked for, to either side.
inline constexpr double largest_delay_s = 0.12;

/// The moving board in an image, or in a depth map and its amplitude; with its time stamp.
struct MovingImage {
    double t_s = 0;
    Corners corners;
};
struct MovingDepth {
    double t_s = 0;
    Corners corners; ///< in the amplitude; empty: the depth is used
    DepthMap depth;
};

struct TimingFit {
    double tof_delay_s = 0;
    double tof_delay_sigma_s = 0;
    double readout_s = 0;
    double readout_sigma_s = 0;
    double speed_px_s = 0; ///< of the board in the images, median
    int images = 0;        ///< used
    int maps = 0;
};

/// The delay and the read-out time from a board that moves steadily before both cameras, of which
/// all else is known: the images give the board's motion, each row at its own time, and the depth
/// maps the time at which they fit into it best. Times of images and of maps rise. Errors: what
/// the recording lacks.
Result<TimingFit> fit_timing(const Board &board, std::span<const MovingImage> images,
                             std::span<const MovingDepth> maps, const RigCalibration &rig);

} // namespace afterglow
