// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/rig_calibration.hpp"
#include "drivers/files/recording.hpp"
#include "drivers/source.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace afterglow {

struct ReplayOptions {
    std::string path;            ///< a folder in TUM layout
    bool real_time = true;       ///< at the recorded pace; otherwise as fast as frames are read
    bool loop = false;           ///< start again at the end
    int wake_latency_frames = 0; ///< images between light on and the first depth map
    int frames = 0;              ///< stop after so many; 0 = all of them
    FrameOrder order{};          ///< before `frames` are counted
    double exposure_changes = 0; ///< of images, SyntheticOptions has the same; stops
    double speed = 1;            ///< of the recorded pace
    /// At the recorded pace: rounds begin at whole multiples of their length on CLOCK_MONOTONIC, in
    /// step with all others who play the recording so.
    bool in_step = false;
    /// The recording is of these two cameras; nothing: its depth is registered to the images.
    std::optional<RigCalibration> rig{};
};

/// How long one round of a recording is: to where its first image would follow its last.
std::int64_t round_length_ns(const Recording &recording);

/// A recording that behaves like a camera with a TOF sensor. Nothing is known of a depth file
/// until the illuminator is lit for its frame: files of unmeasured frames are not even opened, but
/// for the size of the first and the last, which must not both be another camera's. Maps carry
/// their own recorded times.
Result<Rig> open_replay(const ReplayOptions &options);

} // namespace afterglow
