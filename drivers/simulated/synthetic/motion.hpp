// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rigid_motion.hpp"

#include <cstdint>
#include <functional>

namespace afterglow {

/// Something rigid, moving: takes its own points to the world at a time in seconds.
using Motion = std::function<Pose(double t_s)>;

/// Something rigid that stays where it is.
inline Motion at_rest(const Pose &pose = {}) {
    return [pose](double) { return pose; };
}

/// A camera in somebody's hand, who looks around in the middle of a room: smooth, most often 0.1
/// to 0.3 m/s and 5 to 30 deg/s at speed 1, with a small tremor. Stays within 0.75 m of the
/// vertical through the origin and 0.15 m of the origin's height. Speed 0 stands still.
Motion hand_held(std::uint64_t seed, double speed);

} // namespace afterglow
