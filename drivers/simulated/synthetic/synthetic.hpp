// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/simulated/synthetic/motion.hpp"
#include "drivers/simulated/synthetic/noise.hpp"
#include "drivers/simulated/synthetic/scene.hpp"
#include "drivers/source.hpp"

#include <cstdint>

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

/// make_world(), seen by a moving camera. Options out of range are an Error.
Result<Rig> open_synthetic(const SyntheticOptions &options);
/// The same with any other world.
Result<Rig> open_synthetic(const SyntheticOptions &options, SyntheticWorld world);

} // namespace afterglow
