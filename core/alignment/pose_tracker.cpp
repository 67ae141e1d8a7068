// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/pose_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afterglow {
namespace {

/// Root mean square of how far a level's points move in the image from one pose to another, pixels
/// of that level. Points behind the camera at either pose do not count; infinite if all are.
double displacement_px(const AlignmentTemplate &reference, int level, const Pose &a,
                       const Pose &b) {
    constexpr int every = 16;
    const TemplatePoints &points = reference.points(level);
    const Intrinsics &camera = reference.camera(level);
    double squares = 0;
    int count = 0;
    for (int i = 0; i < points.count; i += every) {
        const auto at = static_cast<std::size_t>(i);
        const Eigen::Vector3d X(points.x[at], points.y[at], points.z[at]);
        const Eigen::Vector3d in_a = a * X, in_b = b * X;
        if (in_a.z() <= 0 || in_b.z() <= 0)
            continue;
        squares += (camera.project(in_a) - camera.project(in_b)).squaredNorm();
        ++count;
    }
    return count > 0 ? std::sqrt(squares / count) : std::numeric_limits<double>::infinity();
}

} // namespace

Alignment PoseTracker::track(const AlignmentTemplate &reference, const Pyramid &image,
                             std::span<const Pose> starts, const PosePrior &prior,
                             const Alignment *last) {
    constexpr double near_px = 1;
    constexpr float as_good = 1.1f;
    const int finest = reference.options().finest_level;
    if (last && displacement_px(reference, finest, last->pose, starts[0]) < near_px) {
        Placement from = *last;
        from.pose = starts[0];
        Alignment next =
            alignment_.align(reference, image, from, prior, finest, finest, last->residual_scale);
        if (next.good && next.cost < as_good * last->cost) {
            next.pose = next.pose.normalized();
            return next;
        }
    }
    Alignment found = search(reference, image, starts, prior);
    found.pose = found.pose.normalized();
    return found;
}

Alignment PoseTracker::search(const AlignmentTemplate &reference, const Pyramid &image,
                              std::span<const Pose> starts, const PosePrior &prior) {
    const int coarsest = reference.options().coarsest_level;
    const int finest = reference.options().finest_level;
    // Each start goes as far as the second coarsest level; the best of them all the way. A start
    // within a pixel of the coarsest level of the pose that another has led to would lead there,
    // too.
    const int middle = std::max(coarsest - 1, finest);
    Placement from;
    from.pose = starts[0];
    bool found = alignment_.refine(reference, image, prior, coarsest, middle, from);
    for (const Pose &start : starts.subspan(1)) {
        if (found && displacement_px(reference, coarsest, start, from.pose) < 1)
            continue;
        Placement other;
        other.pose = start;
        if (!alignment_.refine(reference, image, prior, coarsest, middle, other))
            continue;
        const auto cost = [&](const Placement &at) {
            return alignment_.cost(reference, image, at, middle);
        };
        if (!found || cost(other) < cost(from))
            from = other;
        found = true;
    }
    Alignment best = alignment_.align(reference, image, from, prior, middle, finest);
    const auto try_from = [&](const Pose &start) {
        const Placement at = alignment_.with_brightness(reference, image, start, coarsest);
        const Alignment other = alignment_.align(reference, image, at, prior, coarsest, finest);
        if (other.cost < best.cost)
            best = other;
    };
    if (!best.good) // the exposure may have jumped
        try_from(starts[0]);
    if (!best.good)
        try_from(search_rotation(reference, image, starts[0]));
    return best;
}

// 7 x 7 turns about the image's axes, a pixel and a half of the coarsest level apart.
Pose PoseTracker::search_rotation(const AlignmentTemplate &reference, const Pyramid &image,
                                  const Pose &around) {
    const int level = reference.options().coarsest_level;
    const double step = 1.5 / reference.camera(level).fx;
    float least = 1e9f;
    Pose best = around;
    for (int y = -3; y <= 3; ++y)
        for (int x = -3; x <= 3; ++x) {
            Placement at;
            at.pose = Pose{rotation({y * step, x * step, 0}), Eigen::Vector3d::Zero()} * around;
            const float cost = alignment_.cost(reference, image, at, level);
            if (cost < least) {
                least = cost;
                best = at.pose;
            }
        }
    return best;
}

} // namespace afterglow
