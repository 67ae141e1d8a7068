// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/result.hpp"
#include "drivers/source.hpp"

#include <string>

namespace afterglow {

struct ReplayOptions {
    std::string path;            ///< a folder in TUM layout
    bool real_time = true;       ///< at the recorded pace; otherwise as fast as frames are read
    bool loop = false;           ///< start again at the end
    int wake_latency_frames = 0; ///< images between light on and the first depth map
    int frames = 0;              ///< stop after so many; 0 = all of them
};

/// A recording that behaves like a camera with a TOF sensor. Nothing is known of a depth file
/// until the illuminator is lit for its frame: files of unmeasured frames are not even opened.
Result<Rig> open_replay(const ReplayOptions &options);

} // namespace afterglow
