// SPDX-License-Identifier: Apache-2.0
#include "capture/frame_loop.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// Adds the time of its life to `total`.
class Stopwatch {
public:
    explicit Stopwatch(std::chrono::nanoseconds &total) : total_(total) {}
    Stopwatch(const Stopwatch &) = delete;
    Stopwatch &operator=(const Stopwatch &) = delete;
    ~Stopwatch() { total_ += std::chrono::steady_clock::now() - start_; }

private:
    std::chrono::nanoseconds &total_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What `work` gives; the time it takes is added to `total`.
template <class Work>
decltype(auto) timed(std::chrono::nanoseconds &total, Work &&work) {
    const Stopwatch stopwatch(total);
    return work();
}

} // namespace

FrameLoop::FrameLoop(Rig &rig, PipelineFactory make, const GatePolicy &gate,
                     const std::optional<RigGeometry> &geometry)
    : rig_(rig), make_(std::move(make)),
      geometry_(geometry ? *geometry : RigGeometry(rig.color->intrinsics())),
      pipeline_(make_(geometry_)), gate_(gate), pairing_(rig.pairing, geometry_.rig.tof.pinhole),
      pair_lag_(geometry_.registered) {
    const Intrinsics &camera = geometry_.rig.color.pinhole;
    color_.luma = Luma(camera.width, camera.height);
}

void FrameLoop::set_geometry(const RigGeometry &geometry) {
    assert(geometry_.same_sizes(geometry));
    geometry_ = geometry;
    pipeline_ = make_(geometry_);
    pair_lag_ = PairLag(geometry_.registered);
    earlier_worlds_ = last_world_;
    due_ns_.reset();
    gate_.restart();
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
    gate_.restart();
    pipeline_->restart();
    last_t_ns_.reset();
    due_ns_.reset();
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
    timed(result.estimation_time, [&] { pipeline_->prepare(); });
    result.capture = rig_.color->read(color_, timeout);
    if (result.capture == Capture::frame && !is_trusted(result))
        result.capture = Capture::damaged;
    else if (result.capture == Capture::damaged || result.capture == Capture::lost)
        result.problem = rig_.color->problem();
    if (result.capture == Capture::lost || result.capture == Capture::ended)
        set_light(false, result);
    if (result.capture != Capture::frame)
        return result;

    const int due_in = images_until_due();
    const int interval = std::max(images_until(color_.t_ns + depth_interval_.count()), 1);
    // A measurement is compared with a map of its image, and any of those that wait may be that.
    const bool drawn = due_in == 0 || rig_.illuminator->lit();
    last_t_ns_ = color_.t_ns;
    result.luma = color_.luma;
    result.t_ns = color_.t_ns;
    result.sequence = color_.sequence;
    pipeline_->want_depth(drawn);
    pipeline_->want_confidence(confidence_wanted_);
    if (const auto exposed_ns = rig_.tof->exposure_ns())
        pipeline_->expect_lag(pair_lag_.of(color_.t_ns, *exposed_ns + rig_.pairing.delay.count()));
    result.estimate = timed(result.estimation_time, [&]() -> const Estimate & {
        return pipeline_->track(color_.luma, color_.t_ns);
    });
    if (due_in == 0)
        due_ns_ = color_.t_ns;
    const bool wanted = gate_.wants_light(result.estimate, tof_running_,
                                          {.now = drawn, .next_in = drawn ? interval : due_in});
    result.reason = gate_.reason();
    result.budget_spent = gate_.budget_spent();
    if (wanted) {
        measure(result);
    } else {
        set_light(false, result);
        result.lit = rig_.illuminator->was_lit(color_.t_ns);
    }
    if (due_in > 0 && result.estimate.source != FrameSource::measured) {
        result.estimate.depth = {};
        result.estimate.confidence = {};
    }
    if (result.estimate.world > 0)
        result.estimate.world = last_world_ = earlier_worlds_ + result.estimate.world;
    return result;
}

/// Images from the one that was just taken to the first that is due: 0 if that is. Due is the first
/// image after a measurement, because the gate compares later maps with its, and then the images
/// that are nearest to their time.
int FrameLoop::images_until_due() const {
    return due_ns_ ? std::max(images_until(*due_ns_ + depth_interval_.count()), 0) : 0;
}

/// Images from the one that was just taken to the one that is nearest to a time; may be negative.
int FrameLoop::images_until(std::int64_t t_ns) const {
    const double period = static_cast<double>(color_.t_ns - last_t_ns_.value_or(color_.t_ns));
    const auto left = static_cast<double>(t_ns - color_.t_ns);
    return period > 0 ? static_cast<int>(std::ceil(left / period - 0.5)) : 0;
}

bool FrameLoop::is_trusted(FrameResult &result) {
    const Intrinsics &camera = geometry_.rig.color.pinhole;
    if (!camera.has_size(color_.luma.width(), color_.luma.height())) {
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
    result.awaited = true;
    result.lit = rig_.illuminator->was_lit(color_.t_ns);
    // An estimate that is not seen along the TOF camera's rays cannot be compared with its maps.
    const bool comparable = geometry_.publishes_readings() && !result.estimate.depth.empty();
    result.tof = pairing_.read(*rig_.tof, *rig_.illuminator, color_.t_ns,
                               comparable ? result.estimate : Estimate{});
    if (result.tof == Capture::damaged || result.tof == Capture::lost)
        result.problem = pairing_.problem();
    if (result.tof == Capture::lost)
        set_light(false, result);
    if (result.tof != Capture::frame)
        return;
    result.tof_t_ns = pairing_.t_ns();
    result.tof_sequence = pairing_.sequence();
    if (asked_ns_)
        result.wake_latency = std::chrono::nanoseconds(color_.t_ns - *asked_ns_);
    asked_ns_.reset();
    pair_lag_.add_pair(color_.t_ns, pairing_.t_ns());
    result.estimate = timed(result.estimation_time, [&]() -> const Estimate & {
        Measurement measurement = pairing_.depth();
        measurement.amplitude = pairing_.amplitude();
        // Stamps of a live device that registers its depth tell when maps arrive: not used.
        if (!geometry_.registered || rig_.tof->exposure_ns())
            measurement.lag_s = pair_lag_.of(color_.t_ns, pairing_.t_ns());
        if (!geometry_.registered)
            pipeline_->expect_lag(measurement.lag_s);
        return pipeline_->measure(measurement);
    });
    gate_.measured();
    due_ns_.reset();
    // Going dark now and not at the next image saves a frame of light; a camera that measures
    // every frame would only be made to wake again.
    set_light(gate_.keeps_light(), result);
}

bool FrameLoop::set_light(bool lit, FrameResult &result) {
    if (rig_.illuminator->lit() == lit)
        return true;
    const Status done = rig_.illuminator->set(lit);
    asked_ns_.reset();
    if (done && lit) {
        asked_ns_ = color_.t_ns;
        pairing_.relit();
    } else if (!done) {
        light_problem_ = done.error().message;
        result.light_problem = light_problem_;
    }
    return static_cast<bool>(done);
}

} // namespace afterglow
