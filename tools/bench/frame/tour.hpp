// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rigid_motion.hpp"
#include "tools/bench/frames.hpp"

#include <cstddef>
#include <vector>

namespace afterglow::bench {

/// Every so many-th frame of a sequence is a keyframe where no gate decides: about what the gate
/// asks of a hand-held camera.
inline constexpr std::size_t keyframe_interval = 10;

/// A sequence, and where the camera was.
struct Stop {
    Frames frames;
    /// Of each frame: takes points of its keyframe's camera to its own.
    std::vector<Pose> poses;

    std::size_t size() const { return frames.frames.size(); }
    const DecodedFrame &operator[](std::size_t k) const { return frames.frames[k]; }
    static std::size_t keyframe_of(std::size_t k) { return k - k % keyframe_interval; }
};

/// What every benchmark walks through, from the first frame to the last, as often as it likes: so
/// all have the same frames with the same weight.
using Tour = std::vector<Stop>;

/// Frames that are no keyframes.
std::size_t estimated_frames(const Tour &tour);

/// The poses are those that preset "default" finds.
Result<Tour> plan_tour(const std::vector<std::string> &datasets, int frames);

} // namespace afterglow::bench
