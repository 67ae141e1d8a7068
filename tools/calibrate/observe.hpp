// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "tools/calibrate/captures.hpp"
#include "tools/calibrate/rig_fit.hpp"
#include "tools/calibrate/timing_fit.hpp"

#include <functional>
#include <string>
#include <vector>

namespace afterglow {

/// What was found in captures.
struct Observations {
    Intrinsics color_size, tof_size; ///< width and height
    std::vector<BoardView> stills;   ///< blurred views have no corners
    std::vector<MovingImage> images; ///< in which the board was found
    std::vector<MovingDepth> maps;   ///< all; corners where the amplitude shows them
    bool has_amplitude = false;      ///< that shows the board
};

/// Opens all pictures and looks for the board. `say` is told a line about each view. Errors: a
/// picture that cannot be read or has another size than the first of its kind; no view shows the
/// board.
Result<Observations> observe(const Captures &captures,
                             const std::function<void(const std::string &)> &say);

} // namespace afterglow
