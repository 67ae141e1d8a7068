// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/calibrate/rig_fit.hpp"

namespace afterglow {

/// As fit_rig(), where no amplitude shows the board to the TOF camera: the boards' planes, as the
/// colour camera sees them, against the depth that was measured on them. Without a wish the TOF
/// camera's lens is a pinhole or Brown and Conrady's with k1 and k2: what the readings speak
/// for.
Result<RigFit> fit_rig_by_depth(const Board &board, std::span<const BoardView> views,
                                const Intrinsics &color, const Intrinsics &tof,
                                const RigWishes &wishes);

} // namespace afterglow
