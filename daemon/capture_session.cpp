// SPDX-License-Identifier: Apache-2.0
#include "daemon/capture_session.hpp"

#include <algorithm>
#include <ctime>

namespace afterglow {

std::chrono::nanoseconds BackOff::next() {
    const std::chrono::nanoseconds now = delay_;
    delay_ = std::min(delay_ * 2, last);
    return now;
}

CaptureSession::CaptureSession(Rig &rig, const Config &config, WorkerPool &pool, RingWriter &ring,
                               Outbox &outbox)
    : run_without_readers_(config.daemon.run_without_readers), ring_(ring), outbox_(outbox),
      loop_(rig, pipeline_factory(config.estimator, pool), config.gate) {}

CaptureSession::~CaptureSession() {
    loop_.stop();
}

std::chrono::nanoseconds CaptureSession::turn(const Orders &orders, Time now) {
    loop_.gate().set_mode(orders.mode);
    if (ended_)
        return for_ever;
    if (!orders.run && !run_without_readers_)
        return rest();

    if (!color_running_) {
        if (now < color_retry_)
            return color_retry_ - now;
        if (const Status started = loop_.start_color(); !started)
            return lose_color(started.error().message, now);
        color_running_ = true;
        sequence_known_ = false;
        charged_t_ns_.reset();
        damaged_since_image_ = 0;
        last_image_ = now;
        if (outbox_.state() != DaemonState::color_lost)
            outbox_.enter(DaemonState::starting);
    }
    if (!tof_running_ && now >= tof_retry_)
        start_tof(now);

    const FrameResult result = loop_.step(frame_timeout);
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

std::chrono::nanoseconds CaptureSession::rest() {
    if (color_running_ || tof_running_)
        loop_.stop();
    color_running_ = tof_running_ = false;
    tof_well_ = true;
    color_back_off_.reset();
    tof_back_off_.reset();
    color_retry_ = tof_retry_ = Time::min();
    outbox_.enter(DaemonState::idle);
    return for_ever;
}

std::chrono::nanoseconds CaptureSession::end() {
    loop_.stop();
    color_running_ = tof_running_ = false;
    ended_ = true;
    outbox_.enter(DaemonState::stopped);
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
        missed_ += result.sequence - next_sequence_ -
                   std::min(damaged_since_image_, result.sequence - next_sequence_);
    sequence_known_ = true;
    next_sequence_ = result.sequence + 1;
    damaged_since_image_ = 0;
    if (tof_running_)
        watch_tof(result, now);
    outbox_.enter(tof_running_ && tof_well_ ? DaemonState::running : DaemonState::tof_lost);
    publish(result);
}

void CaptureSession::charge(std::int64_t t_ns) {
    timespec used{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    const std::int64_t cpu_ns = used.tv_sec * std::int64_t{1'000'000'000} + used.tv_nsec;
    if (charged_t_ns_) {
        stream_ns_ += t_ns - *charged_t_ns_;
        cpu_ns_ += cpu_ns - charged_cpu_ns_;
    }
    charged_t_ns_ = t_ns;
    charged_cpu_ns_ = cpu_ns;
}

void CaptureSession::publish(const FrameResult &result) {
    afterglow_frame frame = {};
    frame.sequence = result.sequence;
    frame.t_ns = result.t_ns;
    frame.illuminated = result.lit;
    FrameEvent event = {ring_.publish(result.estimate, result.luma, frame), damaged_, missed_};
    charge(result.t_ns);
    event.stream_ns = stream_ns_;
    event.cpu_ns = cpu_ns_;
    if (result.tof == Capture::frame)
        event.pairing_error_ns = std::chrono::abs(result.pairing_error).count();
    if (result.wake_latency)
        event.wake_latency_ns = result.wake_latency->count();
    outbox_.frame(event);
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
}

std::chrono::nanoseconds CaptureSession::lose_color(std::string_view why, Time now) {
    outbox_.note(Priority::error, why);
    loop_.stop();
    color_running_ = tof_running_ = false;
    tof_retry_ = Time::min();
    const std::chrono::nanoseconds delay = color_back_off_.next();
    color_retry_ = now + delay;
    outbox_.enter(DaemonState::color_lost);
    return delay;
}

void CaptureSession::lose_tof(std::string_view why, Time now) {
    outbox_.note(Priority::error, why);
    loop_.stop_tof();
    tof_running_ = tof_well_ = false;
    tof_retry_ = now + tof_back_off_.next();
}

void CaptureSession::damaged(std::string_view why) {
    ++damaged_;
    outbox_.note(Priority::warning, why);
}

} // namespace afterglow
