// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/pose_tracker.hpp"

#include <algorithm>

namespace afterglow {

Alignment PoseTracker::track(const AlignmentTemplate &reference, const Pyramid &image,
                             std::span<const Pose> starts, const PosePrior &prior) const {
    const int coarsest = reference.options().coarsest_level;
    const int finest = reference.options().finest_level;
    // Each start goes as far as the second coarsest level; the best of them all the way.
    const int middle = std::max(coarsest - 1, finest);
    Alignment from;
    from.pose = starts[0];
    float least = 1e9f;
    for (const Pose &start : starts) {
        Alignment at;
        at.pose = start;
        const Alignment rough = alignment_.align(reference, image, at, prior, coarsest, middle);
        if (rough.cost < least) {
            least = rough.cost;
            from = rough;
        }
    }
    Alignment best = alignment_.align(reference, image, from, prior, middle, finest);
    if (!best.good) {
        Alignment turned;
        turned.pose = search_rotation(reference, image, starts[0]);
        const Alignment other = alignment_.align(reference, image, turned, prior, coarsest, finest);
        if (other.cost < best.cost)
            best = other;
    }
    best.pose = best.pose.normalized();
    return best;
}

// 7 x 7 turns about the image's axes, a pixel and a half of the coarsest level apart.
Pose PoseTracker::search_rotation(const AlignmentTemplate &reference, const Pyramid &image,
                                  const Pose &around) const {
    const int level = reference.options().coarsest_level;
    const double step = 1.5 / reference.camera(level).fx;
    float least = 1e9f;
    Pose best = around;
    for (int y = -3; y <= 3; ++y)
        for (int x = -3; x <= 3; ++x) {
            Alignment at;
            at.pose = Pose{rotation({y * step, x * step, 0}), Eigen::Vector3d::Zero()} * around;
            const float cost = alignment_.judge(reference, image, at, level).cost;
            if (cost < least) {
                least = cost;
                best = at.pose;
            }
        }
    return best;
}

} // namespace afterglow
