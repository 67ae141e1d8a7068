// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/oracle.hpp"

#include "core/keyframe/depth_refinement.hpp"
#include "eval/scoring/metrics.hpp"

#include <cmath>

namespace afterglow {

Oracle::Oracle(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
    : camera_(camera), options_(options.keyframe), pool_(pool), estimator_(options, camera, pool),
      keyframes_(options_.compose.keyframes, camera, options_.surface, options_.alignment_template),
      truth_(camera, options_.surface), composer_(camera, options_, pool) {}

const Estimate &Oracle::track(LumaView luma, std::int64_t t_ns, DepthView truth) {
    estimate_ = estimator_.track(luma, t_ns);
    if (keyframes_.size() == 0 || estimate_.source != FrameSource::estimated)
        return estimate_;
    truth_.build(truth, pool_);
    const Pose tracked = estimate_.pose;
    now_ = (tracked * keyframes_[0].depth_from_world).normalized();
    DepthErrors errors = compare_depth(estimate_.depth, truth);
    if (refine(tracked)) {
        const DepthErrors refined = compare_depth(composer_.depth(), truth);
        if (refined.mre <= errors.mre) {
            errors = refined;
            estimate_.depth = composer_.depth();
            estimate_.confidence = composer_.confidence();
        }
    }
    estimate_.expected_mre = static_cast<float>(errors.mre);
    estimate_.fresh_mre = 0;
    estimate_.relative_coverage = static_cast<float>(errors.coverage());
    return estimate_;
}

/// Fits the newest keyframe's map to the true one and composes the depth map anew. False where the
/// two do not fit.
bool Oracle::refine(const Pose &tracked) {
    const DepthRefinementOptions trust;
    Eigen::Matrix<float, 6, 6> information = Eigen::Matrix<float, 6, 6>::Zero();
    information.diagonal().head<3>().setConstant(1 / (trust.start_m * trust.start_m));
    information.diagonal().tail<3>().setConstant(1 / (trust.start_rad * trust.start_rad));
    const Keyframe &newest = keyframes_[0];
    const DepthFit fit =
        refine_by_depth(newest.surface, truth_, camera_, tracked, information, trust);
    if (!fit.good)
        return false;
    now_ = (fit.pose * newest.depth_from_world).normalized();
    composer_.compose(keyframes_, 0, now_, Alignment{}, camera_.width * camera_.height);
    return true;
}

const Estimate &Oracle::measure(DepthView depth) {
    // Where the way here was lost, earlier maps have no place in the view any more.
    if (estimate_.source != FrameSource::estimated) {
        keyframes_.clear();
        now_ = Pose::identity();
    }
    Keyframe &k = keyframes_.push(now_, camera_);
    k.surface.build(depth, pool_);
    k.depth_from_world = now_;
    estimate_ = estimator_.measure(depth);
    return estimate_;
}

OracleLoop::OracleLoop(Footage &footage, const EstimatorOptions &estimator, const GatePolicy &gate,
                       WorkerPool &pool)
    : footage_(footage), oracle_(estimator, footage.rig.color->intrinsics(), pool), gate_(gate) {
    const Intrinsics &camera = footage.rig.color->intrinsics();
    color_.luma = Luma(camera.width, camera.height);
    depth_.depth = DepthMap(camera.width, camera.height);
}

Status OracleLoop::start() {
    if (Status started = footage_.rig.color->start(); !started)
        return started;
    return footage_.rig.tof->start();
}

void OracleLoop::stop() {
    FrameResult ignored;
    light(false, ignored);
    footage_.rig.tof->stop();
    footage_.rig.color->stop();
}

FrameResult OracleLoop::step(std::chrono::nanoseconds timeout) {
    FrameResult result;
    result.capture = footage_.rig.color->read(color_, timeout);
    if (result.capture != Capture::frame) {
        result.problem = footage_.rig.color->problem();
        return result;
    }
    const auto truth = footage_.truth(color_.sequence);
    if (!truth) {
        problem_ = truth.error().message;
        result.capture = Capture::damaged;
        result.problem = problem_;
        return result;
    }
    result.t_ns = color_.t_ns;
    result.sequence = color_.sequence;
    result.luma = color_.luma;
    const auto start = std::chrono::steady_clock::now();
    result.estimate = oracle_.track(color_.luma, color_.t_ns, *truth);
    result.lit = gate_.wants_light(result.estimate);
    light(result.lit, result);
    if (result.lit && read_paired()) {
        result.estimate = oracle_.measure(depth_.depth);
        gate_.measured();
        light(gate_.keeps_light(), result);
    }
    result.estimation_time = std::chrono::steady_clock::now() - start;
    return result;
}

/// Reads the map measured for the current image, past any that came too late for its own.
bool OracleLoop::read_paired() {
    while (footage_.rig.tof->read(depth_, std::chrono::nanoseconds(0)) == Capture::frame)
        if (std::abs(color_.t_ns - depth_.t_ns) <= Pairing().tolerance.count())
            return true;
    return false;
}

void OracleLoop::light(bool lit, FrameResult &result) {
    if (const Status set = footage_.rig.illuminator->set(lit); !set) {
        problem_ = set.error().message;
        result.tof = Capture::lost;
        result.problem = problem_;
    }
}

} // namespace afterglow
