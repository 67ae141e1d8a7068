// SPDX-License-Identifier: Apache-2.0
#include "daemon/capture_session.hpp"

#include "core/base/clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>

namespace afterglow {

std::chrono::nanoseconds BackOff::next() {
    const std::chrono::nanoseconds now = delay_;
    delay_ = std::min(delay_ * 2, last);
    return now;
}

CaptureSession::CaptureSession(Rig &rig, const Config &config, WorkerPool &pool, RingWriter &ring,
                               const StreamNotifier &streams, Outbox &outbox)
    : rig_(rig), run_without_readers_(config.daemon.run_without_readers), pool_(pool), ring_(ring),
      streams_(streams), outbox_(outbox),
      loop_(rig, pipeline_factory(config.estimator, pool), config.gate, rig_geometry(config)) {}

CaptureSession::~CaptureSession() {
    loop_.stop();
}

std::chrono::nanoseconds CaptureSession::turn(const Orders &orders, Time now) {
    obey(orders);
    if (ended_)
        return for_ever;
    if (!wanted(orders, now))
        return rest();

    if (!color_running_) {
        if (now < color_retry_)
            return color_retry_ - now;
        if (const Status started = loop_.start_color(); !started)
            return lose_color(started.error().message, now);
        color_running_ = true;
        first_ = true;
        sequence_known_ = false;
        charged_t_ns_.reset();
        damaged_since_image_ = 0;
        last_image_ = now;
        if (outbox_.state() != DaemonState::color_lost)
            tell(CameraState::starting);
    }
    if (!tof_running_ && now >= tof_retry_)
        start_tof(now);

    loop_.want_confidence(ring_.confidence_wanted());
    loop_.want_depth_every(ring_.wanted_interval());
    const FrameResult result = loop_.step(frame_timeout);
    if (const std::string warning = rig_.tof->take_warning(); !warning.empty())
        outbox_.note(Priority::warning, warning);
    switch (result.capture) {
    case Capture::frame:
        take(result, now);
        break;
    case Capture::damaged:
        ++damaged_since_image_;
        damaged(result.problem);
        last_image_ = now;
        break;
    case Capture::none:
        if (now - last_image_ >= color_stall)
            return lose_color("the colour camera gives no images", now);
        break;
    case Capture::ended:
        return end();
    case Capture::lost:
        return lose_color(result.problem, now);
    }
    return std::chrono::nanoseconds(0);
}

void CaptureSession::obey(const Orders &orders) {
    Gate &gate = loop_.gate();
    if (!(orders.policy == gate.policy()))
        gate.set_policy(orders.policy);
    if (orders.measurements != measurements_ordered_)
        gate.request_measurement();
    measurements_ordered_ = orders.measurements;
    if (orders.geometry && !(*orders.geometry == loop_.geometry())) {
        loop_.set_geometry(*orders.geometry);
        ++calibration_;
    }
}

/// Whether the cameras are to run: a stream is open, or was until a moment ago.
bool CaptureSession::wanted(const Orders &orders, Time now) {
    if (orders.run)
        wanted_until_ = now + std::chrono::nanoseconds(std::llround(1e9 * orders.linger_s));
    return orders.run || run_without_readers_ || now < wanted_until_;
}

/// Tells the daemon's other threads how the cameras are; the colour camera is as said.
void CaptureSession::tell(CameraState color) {
    CameraState tof = tof_running_ ? CameraState::running : CameraState::asleep;
    if (color == CameraState::over || color == CameraState::starting)
        tof = color;
    if (!tof_well_)
        tof = CameraState::lost;
    outbox_.enter({color, tof});
}

std::chrono::nanoseconds CaptureSession::rest() {
    if (color_running_ || tof_running_)
        loop_.stop();
    if (outbox_.state() != DaemonState::idle)
        ring_.clear();
    wanted_until_ = Time::min();
    color_running_ = tof_running_ = false;
    tof_well_ = true;
    color_back_off_.reset();
    tof_back_off_.reset();
    color_retry_ = tof_retry_ = Time::min();
    tell(CameraState::asleep);
    return for_ever;
}

std::chrono::nanoseconds CaptureSession::end() {
    loop_.stop();
    color_running_ = tof_running_ = false;
    ended_ = true;
    tof_well_ = true;
    tell(CameraState::over);
    return for_ever;
}

void CaptureSession::start_tof(Time now) {
    const Status started = loop_.start_tof();
    tof_running_ = static_cast<bool>(started);
    lit_frames_ = 0;
    if (!started)
        lose_tof(started.error().message, now);
}

void CaptureSession::take(const FrameResult &result, Time now) {
    last_image_ = now;
    color_back_off_.reset();
    if (sequence_known_ && result.sequence > next_sequence_)
        losses_.missed += result.sequence - next_sequence_ -
                          std::min(damaged_since_image_, result.sequence - next_sequence_);
    outbox_.count(losses_);
    sequence_known_ = true;
    next_sequence_ = result.sequence + 1;
    damaged_since_image_ = 0;
    if (tof_running_)
        watch_tof(result, now);
    tell(CameraState::running);
    charge(result.t_ns);
    if (!result.estimate.depth.empty()) {
        publish(result);
    } else {
        ++skipped_;
        skipped_lit_ += result.lit;
    }
    pool_.rest(); // until the next image
}

void CaptureSession::charge(std::int64_t t_ns) {
    const std::int64_t cpu_ns = clock_ns(CLOCK_PROCESS_CPUTIME_ID);
    if (charged_t_ns_) {
        stream_ns_ += t_ns - *charged_t_ns_;
        cpu_ns_ += cpu_ns - charged_cpu_ns_;
    }
    charged_t_ns_ = t_ns;
    charged_cpu_ns_ = cpu_ns;
}

void CaptureSession::publish(const FrameResult &result) {
    if (result.tof == Capture::frame) {
        ++measurements_;
        measurement_t_ns_ = result.tof_t_ns;
        tof_sequence_ = result.tof_sequence;
    }
    const Estimate &estimate = result.estimate;
    const CameraModel &camera = loop_.geometry().published;
    afterglow_frame frame = {};
    if (estimate.tracked)
        frame.flags |= AFTERGLOW_FRAME_TRACKED;
    if (first_)
        frame.flags |= AFTERGLOW_FRAME_FIRST;
    if (result.budget_spent)
        frame.flags |= AFTERGLOW_FRAME_BUDGET_SPENT;
    frame.sequence = result.sequence;
    frame.t_ns = result.t_ns;
    frame.emitter = result.lit ? AFTERGLOW_EMITTER_ON : AFTERGLOW_EMITTER_OFF;
    frame.measurement = AFTERGLOW_NO_MEASUREMENT;
    if (estimate.source != FrameSource::none) {
        frame.measurement = measurements_ - 1;
        frame.measurement_t_ns = measurement_t_ns_;
        frame.tof_sequence = tof_sequence_;
    }
    frame.calibration = calibration_;
    frame.fx = camera.pinhole.fx;
    frame.fy = camera.pinhole.fy;
    frame.cx = camera.pinhole.cx;
    frame.cy = camera.pinhole.cy;
    frame.lens = static_cast<std::uint32_t>(camera.lens); // numbered alike
    std::copy(camera.distortion.begin(), camera.distortion.end(), frame.distortion);
    first_ = false;
    FrameEvent event = {ring_.publish(estimate, result.luma, frame, &pool_), result.reason};
    event.stream_ns = stream_ns_;
    event.cpu_ns = cpu_ns_;
    event.skipped = std::exchange(skipped_, 0);
    event.skipped_lit = std::exchange(skipped_lit_, 0);
    if (result.tof == Capture::frame)
        event.pairing_error_ns = std::abs(result.tof_t_ns - result.t_ns);
    event.calibration = estimate.calibration;
    if (result.wake_latency)
        event.wake_latency_ns = result.wake_latency->count();
    calibration_notes_.update(estimate.calibration, outbox_);
    outbox_.frame(event);
    streams_.frame_published(); // wakes the main thread as well
}

void CaptureSession::watch_tof(const FrameResult &result, Time now) {
    switch (result.tof) {
    case Capture::frame:
        tof_well_ = true;
        tof_back_off_.reset();
        lit_frames_ = 0;
        break;
    case Capture::damaged:
        damaged(result.problem);
        lit_frames_ = 0;
        break;
    case Capture::none:
        lit_frames_ = result.awaited ? lit_frames_ + 1 : 0;
        if (lit_frames_ <= 1)
            lit_since_ = now;
        if (lit_frames_ >= tof_stall_frames && now - lit_since_ >= tof_stall)
            lose_tof("the TOF camera is lit and measures nothing", now);
        break;
    case Capture::ended: // of a recording whose images go on: nothing more will be measured
    case Capture::lost:
        lose_tof(result.problem, now);
        break;
    }
    if (!result.light_problem.empty() && tof_running_)
        lose_tof(result.light_problem, now);
}

std::chrono::nanoseconds CaptureSession::lose_color(std::string_view why, Time now) {
    outbox_.lost(Camera::color, why);
    loop_.stop();
    color_running_ = tof_running_ = false;
    tof_retry_ = Time::min();
    const std::chrono::nanoseconds delay = color_back_off_.next();
    color_retry_ = now + delay;
    tell(CameraState::lost);
    return delay;
}

void CaptureSession::lose_tof(std::string_view why, Time now) {
    outbox_.lost(Camera::tof, why);
    loop_.stop_tof();
    tof_running_ = tof_well_ = false;
    tof_retry_ = now + tof_back_off_.next();
}

void CaptureSession::damaged(std::string_view why) {
    ++losses_.damaged;
    outbox_.count(losses_);
    outbox_.note(Priority::warning, why);
}

} // namespace afterglow
