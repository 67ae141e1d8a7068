// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "drivers/simulated/synthetic/motion.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/scene.hpp"
#include "drivers/source.hpp"

#include <cstdint>
#include <optional>

namespace afterglow {

struct SyntheticOptions {
    int width = 640;
    int height = 480;
    double fps = 30;
    std::uint64_t seed = 1;      ///< of the room, the motion and the noise
    bool real_time = true;       ///< at `fps`; otherwise as fast as frames are read
    int wake_latency_frames = 0; ///< images between light on and the first depth map
    int frames = 0;              ///< stop after so many; 0 = for ever
    bool noise = true;           ///< image noise and the TOF noise model
    double motion = 1;           ///< speed of the hand-held camera, relative; 0 = on a tripod
    /// Two cameras, each with its lens and size, instead of one of `width` x `height` that depth is
    /// registered to. A depth map is stamped with its image's time and shows what was there
    /// tof_delay_s later.
    std::optional<RigCalibration> rig{};
    /// By how many stops (factors of 2) the exposure of images drifts and jumps: up to so many up
    /// and down.
    double exposure_changes = 0;
    /// Strength of the light that reaches the TOF camera by way of another surface, which makes
    /// concave corners round; 1 = that of matt surfaces, 0 = none (second_bounce.hpp).
    double multipath = 0;
    /// Time in which the TOF camera takes its four phases; what moves smears (tof_camera.hpp).
    double tof_exposure_ms = 0;
};

/// A scene, the camera's motion through it, and the errors of the TOF camera.
struct SyntheticWorld {
    Scene scene;
    Motion camera; ///< camera to world
    TofNoise tof;  ///< used where SyntheticOptions::noise is set
};

/// A procedural textured room with objects, and a hand-held camera in its middle.
SyntheticWorld make_world(const SyntheticOptions &options);

/// The camera's: 525 pixels of focal length for 640 of width, the centre in the middle.
Intrinsics synthetic_camera(const SyntheticOptions &options);

/// The rig of the options; where they have none, two cameras at one place that are both
/// synthetic_camera().
RigCalibration synthetic_rig(const SyntheticOptions &options);

/// make_world(), seen by a moving camera. Options out of range are an Error.
Result<Rig> open_synthetic(const SyntheticOptions &options);
/// The same with any other world.
Result<Rig> open_synthetic(const SyntheticOptions &options, SyntheticWorld world);

} // namespace afterglow
