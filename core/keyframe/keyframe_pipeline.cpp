// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_pipeline.hpp"

#include <cassert>
#include <utility>

namespace afterglow {

KeyframePipeline::KeyframePipeline(const KeyframeOptions &options, const Intrinsics &camera,
                                   WorkerPool &pool)
    : camera_(camera), pool_(pool),
      keyframes_(options.compose.keyframes, camera, options.surface, options.alignment_template),
      motion_(options.motion), tracker_(options, camera, pool), arriving_(camera, options.surface),
      registration_(options, camera), publication_(options, camera, pool) {}

const Estimate &KeyframePipeline::track(LumaView luma, std::int64_t t_ns) {
    assert(luma.width() == camera_.width && luma.height() == camera_.height);
    const double dt = 1e-9 * static_cast<double>(t_ns - t_ns_);
    t_ns_ = t_ns;
    tracker_.load(luma);
    if (keyframes_.size() == 0)
        return publication_.nothing(t_ns);
    tracker_.align(keyframes_, t_ns, dt, publication_.composed(), registration_.correction(),
                   motion_);
    depth_now_ = lag() * motion_.now();
    return publication_.estimated(keyframes_, tracker_, depth_now_, registration_.correction(),
                                  t_ns);
}

const Estimate &KeyframePipeline::measure(DepthView depth) {
    assert(depth.width() == camera_.width && depth.height() == camera_.height);
    arriving_.build(depth, pool_, registration_.correction());
    if (keyframes_.size() > 0)
        register_map();
    if (keyframes_.size() == 0)
        forget();
    Keyframe &k = keyframes_.push(depth_now_, camera_);
    std::swap(k.surface, arriving_);
    k.alignment_template.build(tracker_.image(), k.surface);
    k.from_world = motion_.now();
    k.depth_from_world = depth_now_;
    k.t_ns = t_ns_;
    k.turning = motion_.turning();
    tracker_.keyframe_added();
    return publication_.measured(depth, k);
}

/// Places the arriving map among the keyframes; where neither images nor geometry tell its place,
/// the keyframes are forgotten.
void KeyframePipeline::register_map() {
    const Keyframe &reference = keyframes_[tracker_.reference()];
    const DepthFit fit = registration_.add(reference, arriving_, depth_now_, tracker_.alignment(),
                                           motion_.turning());
    if (fit.good) {
        depth_now_ = (fit.pose * reference.depth_from_world).normalized();
        motion_.correct((lag().inverse() * depth_now_).normalized());
    } else if (!tracker_.alignment().good) {
        keyframes_.clear();
    }
}

/// The next map begins a new world.
void KeyframePipeline::forget() {
    depth_now_ = Pose::identity();
    motion_.restart();
    publication_.begin_world();
}

} // namespace afterglow
