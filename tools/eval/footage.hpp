// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/image.hpp"
#include "core/result.hpp"
#include "drivers/source.hpp"
#include "drivers/synthetic/synthetic.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace afterglow {

/// Frames to evaluate on: the rig that gives them, and what they really show.
struct Footage {
    std::string name;
    Rig rig;
    int frames = 0;      ///< how many there are
    int left_out = 0;    ///< frames of the recording that cannot be used
    std::string problem; ///< the sentence behind the first of those
    /// The true depth map of the image with that ColorFrame::sequence. Asked for only after the
    /// frame has been estimated, but by the oracle.
    std::function<Result<DepthMap>(std::uint64_t sequence)> truth;
};

/// A recording in TUM layout, as fast as it can be read. `frames` 0: all of it.
Result<Footage> open_recorded_footage(const std::string &folder, int frames, int wake_latency);

/// The synthetic room. `options.frames` bounds it.
Result<Footage> open_synthetic_footage(SyntheticOptions options);

} // namespace afterglow
