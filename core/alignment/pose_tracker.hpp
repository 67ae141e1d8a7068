// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/direct_alignment.hpp"

namespace afterglow {

/// Finds the pose of an image against a keyframe: picks the best of several starts at the coarsest
/// level and aligns. If the result is not believed, tries the first start with the gain and offset
/// of an exposure that has jumped, then a fan of rotations around it. Allocates when made; track()
/// is real-time safe, and nothing is kept between calls.
class PoseTracker {
public:
    /// For templates of at most so many points a level.
    PoseTracker(const AlignmentOptions &options, int points_per_level, WorkerPool &pool)
        : alignment_(options, points_per_level, pool) {}

    /// `starts`: possible poses, the first is preferred; at least one. `last`: how the image before
    /// was aligned with the same template, good; null: it was not. If the first start is next to it
    /// and leads to an alignment as good as it on the finest level, nothing else is tried.
    Alignment track(const AlignmentTemplate &reference, const Pyramid &image,
                    std::span<const Pose> starts, const PosePrior &prior = {},
                    const Alignment *last = nullptr);

private:
    Alignment search(const AlignmentTemplate &reference, const Pyramid &image,
                     std::span<const Pose> starts, const PosePrior &prior);
    Pose search_rotation(const AlignmentTemplate &reference, const Pyramid &image,
                         const Pose &around);

    DirectAlignment alignment_;
};

} // namespace afterglow
