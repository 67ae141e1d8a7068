// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_tracker.hpp"

#include <array>
#include <utility>

namespace afterglow {

KeyframeTracker::KeyframeTracker(const KeyframeOptions &options, const Views &views,
                                 WorkerPool &pool)
    : views_(views), pool_(pool),
      tracker_(options.alignment, options.alignment_template.points_per_level, pool),
      newest_bonus_(options.compose.newest_bonus / 100),
      image_(views.tracking.width, views.tracking.height,
             options.alignment_template.coarsest_level),
      previous_image_(image_), composed_surface_(views.published, options.surface),
      previous_(views.published, views.tracking, views.published_from_tracking.inverse(),
                options.surface, options.warp, pool),
      previous_template_(views.tracking, options.alignment_template) {}

void KeyframeTracker::load(LumaView luma) {
    std::swap(image_, previous_image_);
    image_.build(luma, pool_);
}

/// The keyframe that most of the predicted view is of; the newest, if about as much.
int KeyframeTracker::pick_reference(const KeyframeSet &keyframes, const Pose &predicted) const {
    int best = 0;
    float most = -1;
    for (int i = 0; i < keyframes.size(); ++i) {
        const Pose pose =
            predicted * keyframes[i].from_world.inverse() * views_.surface_from_tracking.inverse();
        const float share =
            visible_share(keyframes[i].surface, views_.surface, pose, views_.tracking) +
            (i == 0 ? newest_bonus_ : 0.0f);
        if (share > most) {
            most = share;
            best = i;
        }
        if (most >= 1) // none has more than all of itself in view
            break;
    }
    return best;
}

void KeyframeTracker::align(const KeyframeSet &keyframes, std::int64_t t_ns, double dt,
                            DepthView previous_depth, const DepthCorrection &correction,
                            CameraMotion &motion) {
    const Pose now = motion.now(), predicted = motion.predicted(dt);
    reference_ = pick_reference(keyframes, predicted);
    const Keyframe &k = keyframes[reference_];
    const Pose to_world = k.from_world.inverse();
    const Pose turned{predicted.R, predicted.R * now.R.transpose() * now.T};
    const std::array<Pose, 3> starts{predicted * to_world, now * to_world, turned * to_world};

    const double age_s = 1e-9 * static_cast<double>(t_ns - k.t_ns);
    const bool comparable = aligned_ == k.t_ns && alignment_.good && !bridged_;
    aligned_ = k.t_ns;
    alignment_ = tracker_.track(k.alignment_template, image_, starts,
                                motion.prior(starts[0], k.rate, dt, age_s),
                                comparable ? &alignment_ : nullptr);
    bridged_ = !alignment_.good && !previous_depth.empty() &&
               bridge(k.from_world, predicted, dt, previous_depth, correction, motion);
    if (alignment_.good)
        last_good_covariance_ = alignment_.covariance;
    const bool usable = alignment_.points > 0 && alignment_.pose.is_finite();
    const Pose pose = usable ? alignment_.pose * k.from_world : predicted;
    motion.advance(pose.normalized(), alignment_.good, dt);
}

/// True if the step from the image before gave a pose; its covariance is that of all steps so far.
bool KeyframeTracker::bridge(const Pose &reference_from_world, const Pose &predicted, double dt,
                             DepthView previous_depth, const DepthCorrection &correction,
                             const CameraMotion &motion) {
    composed_surface_.build(previous_depth, pool_, correction);
    previous_template_.build(previous_image_, previous_.seen(composed_surface_));
    const std::array<Pose, 2> starts{predicted * motion.now().inverse(), Pose::identity()};
    step_ = tracker_.track(previous_template_, image_, starts,
                           motion.prior(starts[0], motion.rate(), dt, dt));
    if (!step_.good)
        return false;
    const Pose back = reference_from_world * motion.now().inverse();
    const Eigen::Matrix<float, 6, 6> A = adjoint(back).cast<float>();
    alignment_ = step_;
    alignment_.skew.setZero();
    alignment_.pose = step_.pose * back.inverse();
    alignment_.covariance = last_good_covariance_ + A * step_.covariance * A.transpose();
    return true;
}

const AlignmentTemplate &KeyframeTracker::compared(const KeyframeSet &keyframes) const {
    return bridged_ ? previous_template_ : keyframes[reference_].alignment_template;
}

} // namespace afterglow
