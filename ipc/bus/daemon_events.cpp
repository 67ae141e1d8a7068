// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/daemon_events.hpp"

namespace afterglow {

std::string_view to_string(Camera camera) {
    return camera == Camera::color ? "color" : "tof";
}

std::string_view to_string(CameraState state) {
    switch (state) {
    case CameraState::asleep:
        return "asleep";
    case CameraState::starting:
        return "starting";
    case CameraState::running:
        return "running";
    case CameraState::lost:
        return "lost";
    case CameraState::over:
        break;
    }
    return "over";
}

std::string_view to_string(DaemonState state) {
    switch (state) {
    case DaemonState::starting:
        return "starting";
    case DaemonState::running:
        return "running";
    case DaemonState::idle:
        return "idle";
    case DaemonState::color_lost:
        return "color-lost";
    case DaemonState::tof_lost:
        return "tof-lost";
    case DaemonState::stopped:
        break;
    }
    return "stopped";
}

} // namespace afterglow
