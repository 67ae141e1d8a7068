// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/direct_alignment.hpp"

namespace afterglow {

/// Finds the pose of an image against a keyframe: picks the best of several starts at the coarsest
/// level, aligns, and if the result is not believed tries the other starts and then a fan of
/// rotations around the previous pose. Real-time safe; keeps no state.
class PoseTracker {
public:
    explicit PoseTracker(const AlignmentOptions &options) : alignment_(options) {}

    /// `starts`: possible poses, the first is preferred; at least one.
    Alignment track(const AlignmentTemplate &reference, const Pyramid &image,
                    std::span<const Pose> starts, const PosePrior &prior = {}) const;

    const DirectAlignment &alignment() const { return alignment_; }

private:
    Pose search_rotation(const AlignmentTemplate &reference, const Pyramid &image,
                         const Pose &around) const;

    DirectAlignment alignment_;
};

} // namespace afterglow
