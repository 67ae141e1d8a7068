// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "eval/experiments/watch.hpp"
#include "eval/scoring/footage.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace afterglow {

/// Frames in memory, so that many systems can be shown the same ones.
struct Sequence {
    struct Frame {
        std::int64_t t_ns = 0;
        Luma luma;
        DepthMap measured;               ///< what a lit TOF camera gives
        DepthMap truth;                  ///< empty: what was measured is all that is known
        std::int64_t depth_after_ns = 0; ///< from t_ns to when `measured` was taken
        const DepthMap &true_depth() const { return truth.empty() ? measured : truth; }
    };

    std::string name;
    std::string layout;
    std::string note; ///< a sentence on what was left out or assumed; or empty
    Intrinsics camera;
    std::vector<Frame> frames; ///< at least one
};

/// The sequence as a rig, as fast as its frames are read, and its truth. With `repeated_fps` it
/// begins again and again, with times that go on at that rate. `sequence` must outlive it.
Footage footage_of(const Sequence &sequence, double repeated_fps = 0);

/// The first `frames` good frames of a dataset in any layout (0: all), or of the synthetic room
/// where `source` is "synthetic". "synthetic:nyu-v2", and so for the paper's other datasets that
/// synthetic_sources() names, is what stands in for one that is not at hand: the room, filmed as
/// slowly or quickly and measured as well or badly as that one was.
Result<Sequence> load_sequence(const std::string &source, int frames, Watch &watch);

/// The sources that are synthetic: the room and the stand-ins.
std::vector<std::string> synthetic_sources();
bool is_stand_in(const std::string &source);

} // namespace afterglow
