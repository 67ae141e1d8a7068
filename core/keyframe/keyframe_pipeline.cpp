// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_pipeline.hpp"

#include <cassert>
#include <utility>

namespace afterglow {

KeyframePipeline::KeyframePipeline(const KeyframeOptions &options, const Views &views,
                                   WorkerPool &pool)
    : views_(views), pool_(pool),
      keyframes_(options.compose.keyframes, views, options.surface, options.alignment_template),
      motion_(options.motion), tracker_(options, views, pool),
      arriving_(views.surface, options.surface), registration_(options, views),
      seen_(views.surface, views.tracking, views.surface_from_tracking.inverse(), options.surface,
            options.warp, pool),
      published_(views.surface, views.published, views.published_from_surface(), options.surface,
                 options.warp, pool),
      publication_(options, views, pool) {
    if (views.calibrated && options.correct_calibration)
        guard_ = std::make_unique<CalibrationGuard>(
            views, options.alignment_template.coarsest_level, options.warp, pool);
}

const Estimate &KeyframePipeline::track(LumaView luma, std::int64_t t_ns) {
    assert(luma.width() == views_.tracking.width && luma.height() == views_.tracking.height);
    const double dt = 1e-9 * static_cast<double>(t_ns - t_ns_);
    t_ns_ = t_ns;
    prepare();
    stated_lag_s_ = expected_lag_s_;
    tracker_.load(luma);
    if (keyframes_.size() == 0)
        return publication_.nothing(t_ns);
    tracker_.align(keyframes_, t_ns, dt, publication_.composed(), published_correction(), motion_);
    depth_now_ = views_.surface_from_tracking * lag() * motion_.now();
    const Estimate &tracked = publication_.tracked(tracker_.alignment(), published_now(), t_ns);
    return depth_wanted_ ? draw() : tracked;
}

const Estimate &KeyframePipeline::measure(const Measurement &measurement) {
    assert(measurement.depth.width() == views_.surface.width &&
           measurement.depth.height() == views_.surface.height);
    prepare();
    if (!publication_.has_map() && keyframes_.size() > 0)
        draw(); // errors are learnt from it
    if (stated_lag_s_ != measurement.lag_s) {
        stated_lag_s_ = measurement.lag_s;
        depth_now_ = views_.surface_from_tracking * lag() * motion_.now();
    }
    arriving_.read(measurement.depth, pool_, registration_.correction(), measurement.amplitude);
    if (warps_arriving())
        arriving_.finish();
    if (guard_ && guard_->check(arriving_, motion_, measurement.lag_s, tracker_.image()))
        keyframes_.clear(); // they were placed by another calibration
    std::optional<MapComparison> compared;
    if (keyframes_.size() > 0)
        compared = register_map();
    if (keyframes_.size() == 0)
        forget();
    Keyframe &k = keyframes_.push(depth_now_);
    std::swap(k.surface, arriving_);
    k.from_world = motion_.now();
    k.depth_from_world = depth_now_;
    k.t_ns = t_ns_;
    k.rate = motion_.rate();
    prepared_ = false;
    tracker_.keyframe_added();
    if (guard_)
        k.calibration_shift = guard_->shift();
    const Pose from_world = published_now();
    const DepthView shown =
        views_.publishes_readings()
            ? measurement.depth
            : published_.rendered(k.surface, from_world * depth_now_.inverse(),
                                  views_.publishes_tracking() ? while_read() : Twist::Zero());
    return publication_.measured(shown, k, from_world,
                                 guard_ ? guard_->state() : CalibrationState{}, compared);
}

/// Readies the newest keyframe for being compared with later images, and for being drawn: what is
/// published of a measured frame does not wait for that.
void KeyframePipeline::prepare() {
    if (std::exchange(prepared_, true) || keyframes_.size() == 0)
        return;
    Keyframe &newest = keyframes_[0];
    newest.surface.finish();
    copy_pixels(tracker_.image().level(publication_.flow_level()), newest.grey.view());
    newest.alignment_template.build(tracker_.image(),
                                    seen_.seen(newest.surface, lag().inverse(), while_read()));
}

/// Whether a measured map is warped for what is published of it.
bool KeyframePipeline::warps_arriving() const {
    return guard_ || !views_.publishes_readings();
}

Pose KeyframePipeline::published_now() const {
    // What is published along the TOF camera's rays is what it would read, when it would.
    return views_.publishes_surface() ? views_.published_from_surface() * depth_now_
                                      : views_.published_from_tracking * motion_.now();
}

DepthCorrection KeyframePipeline::published_correction() const {
    return views_.publishes_surface() ? registration_.correction() : DepthCorrection{};
}

/// Makes the depth map of the image last tracked.
const Estimate &KeyframePipeline::draw() {
    return publication_.estimated(keyframes_, tracker_, published_now(), motion_.rate(),
                                  published_correction());
}

/// Places the arriving map among the keyframes; where neither images nor geometry tell its place,
/// the keyframes are forgotten. Returns how the map and the reference differ, if enough of both
/// could be compared.
std::optional<MapComparison> KeyframePipeline::register_map() {
    const Keyframe &reference = keyframes_[tracker_.reference()];
    const DepthFit fit =
        registration_.add(reference, arriving_, depth_now_, tracker_.alignment(), motion_.rate());
    if (fit.good) {
        depth_now_ = (fit.pose * reference.depth_from_world).normalized();
        motion_.correct(
            (lag().inverse() * views_.surface_from_tracking.inverse() * depth_now_).normalized());
    } else if (!tracker_.alignment().good) {
        keyframes_.clear();
    }
    // Maps that do not fit tell all the more of their errors.
    if (!(fit.relative_error > 0))
        return std::nullopt;
    return MapComparison{fit.relative_error,
                         mean_displacement(reference.surface, views_.surface, fit.pose)};
}

/// The next map begins a new world.
void KeyframePipeline::forget() {
    depth_now_ = views_.surface_from_tracking;
    motion_.restart();
    publication_.begin_world();
}

} // namespace afterglow
