// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/ring.h"
#include "core/calibration_state.hpp"
#include "core/gate.hpp"

#include <cstdint>
#include <string_view>

namespace afterglow {

// What the thread that captures tells the thread that serves the bus.

enum class Camera : std::uint8_t { color, tof };

enum class CameraState : std::uint8_t {
    asleep,   ///< nobody reads, or the other camera is lost
    starting, ///< started, and has given nothing yet
    running,
    lost, ///< it failed; it is started again and again
    over, ///< the recording has ended
};

struct alignas(2) CameraStates {
    CameraState color = CameraState::starting;
    CameraState tof = CameraState::starting;

    bool operator==(const CameraStates &) const = default;
};

/// The states of the daemon.
enum class DaemonState { starting, running, idle, color_lost, tof_lost, stopped };

/// What both cameras' states make of the daemon's.
constexpr DaemonState daemon_state(CameraStates cameras) {
    switch (cameras.color) {
    case CameraState::asleep:
        return DaemonState::idle;
    case CameraState::starting:
        return DaemonState::starting;
    case CameraState::lost:
        return DaemonState::color_lost;
    case CameraState::over:
        return DaemonState::stopped;
    case CameraState::running:
        break;
    }
    return cameras.tof == CameraState::lost ? DaemonState::tof_lost : DaemonState::running;
}

/// The names on D-Bus: "color", "tof"; "asleep"; "color-lost".
std::string_view to_string(Camera camera);
std::string_view to_string(CameraState state);
std::string_view to_string(DaemonState state);

/// What has come to nothing since the daemon's start.
struct FrameLosses {
    std::uint64_t damaged = 0; ///< images and depth maps that came but were unusable
    std::uint64_t missed = 0;  ///< images that the colour camera counted but did not deliver
};

/// A published frame.
struct FrameEvent {
    afterglow_frame frame;
    GateReason reason = GateReason::none; ///< why the gate wants light; none: it does not
    std::int64_t stream_ns = 0;           ///< time between images so far, while the cameras ran
    std::int64_t cpu_ns = 0;              ///< CPU time of the process in that time
    std::int64_t pairing_error_ns = -1;   ///< between image and measurement; -1: not measured
    std::int64_t wake_latency_ns = -1;    ///< of a light that had to go on for it; -1: none
    CalibrationState calibration{};       ///< as the measurements so far show it
    std::uint32_t skipped = 0; ///< images since the frame before that no reader wanted a frame of
    std::uint32_t skipped_lit = 0; ///< those of them for which the light was on
};

} // namespace afterglow
