// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ipc/bus/daemon_events.hpp"

#include <optional>

namespace afterglow {

/// How the daemon is, as far as promises to clients depend on it.
struct Situation {
    GateMode mode = GateMode::automatic; ///< that rules
    CameraStates cameras;
    std::optional<FrameEvent> frame = {}; ///< the newest since the cameras were started

    bool running() const { return cameras.color == CameraState::running; }
    bool budget_spent() const {
        return frame && (frame->frame.flags & AFTERGLOW_FRAME_BUDGET_SPENT) != 0;
    }
};

} // namespace afterglow
