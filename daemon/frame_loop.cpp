// SPDX-License-Identifier: Apache-2.0
#include "daemon/frame_loop.hpp"

#include <algorithm>
#include <cstdlib>

namespace afterglow {
namespace {

/// More maps than a driver can have kept while the light was dark.
constexpr int max_stale_maps = 16;

bool has_size(const Intrinsics &camera, int width, int height) {
    return width == camera.width && height == camera.height;
}

/// Percent of the pixels that have depth.
double coverage(const DepthMap &depth) {
    const auto pixels = depth.pixels();
    const auto holes = std::count(pixels.begin(), pixels.end(), std::uint16_t{0});
    return 100.0 * static_cast<double>(static_cast<std::ptrdiff_t>(pixels.size()) - holes) /
           static_cast<double>(std::max<std::size_t>(pixels.size(), 1));
}

/// What `work` gives; the time it takes is added to `total`.
template <class Work>
decltype(auto) timed(std::chrono::nanoseconds &total, Work &&work) {
    const auto start = std::chrono::steady_clock::now();
    decltype(auto) result = work();
    total += std::chrono::steady_clock::now() - start;
    return result;
}

} // namespace

FrameLoop::FrameLoop(Rig &rig, const EstimatorOptions &estimator, const GatePolicy &gate,
                     WorkerPool &pool)
    : rig_(rig), options_(estimator), policy_(gate), pool_(pool) {
    const Intrinsics &color = rig.color->intrinsics();
    color_.luma = Luma(color.width, color.height);
    depth_.depth = DepthMap(color.width, color.height);
    gate_.emplace(policy_);
    estimator_.emplace(options_, color, pool_);
}

Status FrameLoop::start() {
    if (Status started = start_color(); !started)
        return started;
    Status started = start_tof();
    if (!started)
        stop();
    return started;
}

Status FrameLoop::start_color() {
    Status started = rig_.color->start();
    if (!started)
        return started;
    policy_.mode = gate_->mode();
    gate_.emplace(policy_);
    estimator_.emplace(options_, rig_.color->intrinsics(), pool_);
    last_t_ns_.reset();
    return ok();
}

Status FrameLoop::start_tof() {
    Status started = rig_.tof->start();
    tof_running_ = static_cast<bool>(started);
    return started;
}

void FrameLoop::stop() {
    stop_tof();
    rig_.color->stop();
}

void FrameLoop::stop_tof() {
    FrameResult ignored;
    set_light(false, ignored);
    rig_.tof->stop();
    tof_running_ = false;
}

FrameResult FrameLoop::step(std::chrono::nanoseconds timeout) {
    FrameResult result;
    result.capture = rig_.color->read(color_, timeout);
    if (result.capture == Capture::frame && !is_trusted(result))
        result.capture = Capture::damaged;
    else if (result.capture == Capture::damaged || result.capture == Capture::lost)
        result.problem = rig_.color->problem();
    if (result.capture == Capture::lost || result.capture == Capture::ended)
        set_light(false, result);
    if (result.capture != Capture::frame)
        return result;

    last_t_ns_ = color_.t_ns;
    result.luma = color_.luma;
    result.t_ns = color_.t_ns;
    result.sequence = color_.sequence;
    result.estimate = timed(result.estimation_time, [&]() -> const Estimate & {
        return estimator_->track(color_.luma, color_.t_ns);
    });
    if (gate_->wants_light(result.estimate) && tof_running_)
        measure(result);
    else
        set_light(false, result);
    return result;
}

bool FrameLoop::is_trusted(FrameResult &result) {
    const Intrinsics &camera = rig_.color->intrinsics();
    if (!has_size(camera, color_.luma.width(), color_.luma.height())) {
        result.problem = "the image has not the size of the camera's images";
        color_.luma = Luma(camera.width, camera.height);
    } else if (last_t_ns_ && color_.t_ns <= *last_t_ns_) {
        result.problem = "the image is not later than the one before it";
    }
    return result.problem.empty();
}

void FrameLoop::measure(FrameResult &result) {
    if (!set_light(true, result))
        return;
    result.lit = true;
    result.tof = read_paired(result);
    if (result.tof == Capture::lost) {
        set_light(false, result);
    } else if (result.tof == Capture::frame) {
        result.estimate = timed(result.estimation_time, [&]() -> const Estimate & {
            return estimator_->measure(depth_.depth);
        });
        gate_->measured();
        // Going dark now and not at the next image saves a frame of light; a camera that measures
        // every frame would only be made to wake again.
        set_light(gate_->keeps_light(), result);
    }
}

Capture FrameLoop::read_paired(FrameResult &result) {
    const Intrinsics &camera = rig_.color->intrinsics(); // depth is registered to it
    for (int attempt = 0; attempt < max_stale_maps; ++attempt) {
        const Capture capture = rig_.tof->read(depth_, std::chrono::nanoseconds(0));
        if (capture == Capture::damaged || capture == Capture::lost)
            result.problem = rig_.tof->problem();
        if (capture != Capture::frame)
            return capture;
        if (!has_size(camera, depth_.depth.width(), depth_.depth.height())) {
            result.problem = "the depth map has not the size of the camera's maps";
            depth_.depth = DepthMap(camera.width, camera.height);
            return Capture::damaged;
        }
        // Maps of images that have passed are of no use; they only stand before the one that is.
        const std::int64_t late_by = color_.t_ns - depth_.t_ns;
        if (late_by > pairing_tolerance.count())
            continue;
        if (late_by < -pairing_tolerance.count()) {
            result.problem = "the depth map belongs to no image";
            return Capture::damaged;
        }
        if (coverage(depth_.depth) < min_measured_coverage) {
            result.problem = "the depth map is all but empty";
            return Capture::damaged;
        }
        return Capture::frame;
    }
    return Capture::none;
}

bool FrameLoop::set_light(bool lit, FrameResult &result) {
    if (rig_.illuminator->lit() == lit)
        return true;
    const Status done = rig_.illuminator->set(lit);
    if (!done) {
        light_problem_ = done.error().message;
        result.tof = Capture::lost;
        result.problem = light_problem_;
    }
    return static_cast<bool>(done);
}

} // namespace afterglow
