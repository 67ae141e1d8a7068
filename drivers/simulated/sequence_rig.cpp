// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/sequence_rig.hpp"

#include "core/base/clock.hpp"

#include <cassert>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>

namespace afterglow {
namespace {

/// The device behind the three interfaces.
class Device {
public:
    Device(std::unique_ptr<FrameSequence> sequence, const Playback &playback,
           std::shared_ptr<Clock> clock)
        : sequence_(std::move(sequence)), playback_(playback), clock_(std::move(clock)) {}

    const Intrinsics &intrinsics() const { return sequence_->intrinsics(); }
    const Intrinsics &tof_intrinsics() const { return sequence_->tof_intrinsics(); }
    bool lit() const { return lit_; }

    void start_color() {
        color_running_ = true;
        start_ns_ = clock_->now_ns();
        if (playback_.round_ns > 0)
            start_ns_ = next_round_ns(start_ns_, playback_.round_ns);
        next_ = 0;
        turn_.reset();
        measured_.reset();
        wake();
    }
    void stop_color() { color_running_ = false; }

    void run_tof(bool running) {
        tof_running_ = running;
        wake();
    }

    void set_lit(bool lit) {
        if (lit == lit_)
            return;
        lit_ = lit;
        wake();
    }

    Capture read_color(ColorFrame &frame, std::int64_t timeout_ns, std::string &problem) {
        if (!color_running_)
            return Capture::none;
        if (!exists(next_))
            return Capture::ended;
        if (playback_.real_time) {
            const std::int64_t now = clock_->now_ns();
            while (exists(next_ + 1) && due_ns(next_ + 1) <= now)
                ++next_;
            if (due_ns(next_) - now > timeout_ns) {
                clock_->sleep_until(now + timeout_ns);
                return Capture::none;
            }
        }
        const std::uint64_t k = next_++;
        turn_ = k;
        // Read before it is due: what that costs is no part of the latency of a camera's image.
        assert(intrinsics().has_size(frame.luma.width(), frame.luma.height()));
        const Status read = sequence_->read_luma(k, frame.luma.view());
        if (playback_.real_time)
            clock_->sleep_until(due_ns(k));
        if (!read) {
            problem = read.error().message;
            return Capture::damaged;
        }
        frame.t_ns = due_ns(k);
        frame.sequence = k;
        return Capture::frame;
    }

    Capture read_depth(DepthFrame &frame, std::string &problem) {
        if (!first_awake_ || !turn_ || *turn_ < *first_awake_ || measured_ == turn_)
            return Capture::none;
        measured_ = turn_;
        assert(tof_intrinsics().has_size(frame.depth.width(), frame.depth.height()));
        const Status read = sequence_->read_depth(*turn_, frame.depth.view());
        if (!read) {
            problem = read.error().message;
            return Capture::damaged;
        }
        sequence_->read_amplitude(*turn_, frame.amplitude);
        frame.t_ns = played_ns(sequence_->depth_time_ns(*turn_));
        frame.sequence = *turn_;
        return Capture::frame;
    }

    std::optional<std::int64_t> exposure_ns() const {
        if (!turn_)
            return std::nullopt;
        return played_ns(sequence_->depth_time_ns(*turn_));
    }

private:
    bool exists(std::uint64_t k) const {
        const auto frames = static_cast<std::uint64_t>(playback_.frames);
        return (frames == 0 || k < frames) && sequence_->time_ns(k).has_value();
    }
    std::int64_t due_ns(std::uint64_t k) const { return played_ns(*sequence_->time_ns(k)); }
    /// The sequence's time on the clock of frames.
    std::int64_t played_ns(std::int64_t t_ns) const {
        if (!playback_.real_time)
            return t_ns;
        return start_ns_ +
               std::llround(static_cast<double>(t_ns - *sequence_->time_ns(0)) / playback_.speed);
    }
    /// The TOF camera goes to sleep, or begins to wake.
    void wake() {
        first_awake_.reset();
        if (lit_ && tof_running_)
            first_awake_ =
                turn_.value_or(0) + static_cast<std::uint64_t>(playback_.wake_latency_frames);
    }

    std::unique_ptr<FrameSequence> sequence_;
    Playback playback_;
    std::shared_ptr<Clock> clock_;
    bool color_running_ = false;
    bool tof_running_ = false;
    bool lit_ = false;
    std::int64_t start_ns_ = 0;
    std::uint64_t next_ = 0;
    std::optional<std::uint64_t> turn_;        ///< the image last read
    std::optional<std::uint64_t> first_awake_; ///< the first image with depth; none in the dark
    std::optional<std::uint64_t> measured_;    ///< the image that last had its depth read
};

class ColorFace : public ColorSource {
public:
    explicit ColorFace(std::shared_ptr<Device> device) : device_(std::move(device)) {}
    const Intrinsics &intrinsics() const override { return device_->intrinsics(); }
    Status start() override {
        device_->start_color();
        return ok();
    }
    void stop() override { device_->stop_color(); }
    Capture read(ColorFrame &frame, std::chrono::nanoseconds timeout) override {
        return device_->read_color(frame, timeout.count(), problem_);
    }
    const std::string &problem() const override { return problem_; }

private:
    std::shared_ptr<Device> device_;
    std::string problem_;
};

class TofFace : public TofSource {
public:
    explicit TofFace(std::shared_ptr<Device> device) : device_(std::move(device)) {}
    const Intrinsics &intrinsics() const override { return device_->tof_intrinsics(); }
    Status start() override {
        device_->run_tof(true);
        return ok();
    }
    void stop() override { device_->run_tof(false); }
    Capture read(DepthFrame &frame, std::chrono::nanoseconds /*timeout*/) override {
        return device_->read_depth(frame, problem_);
    }
    std::optional<std::int64_t> exposure_ns() const override { return device_->exposure_ns(); }
    const std::string &problem() const override { return problem_; }

private:
    std::shared_ptr<Device> device_;
    std::string problem_;
};

class LightFace : public Illuminator {
public:
    explicit LightFace(std::shared_ptr<Device> device) : device_(std::move(device)) {}
    ~LightFace() override { device_->set_lit(false); }
    LightFace(const LightFace &) = delete;
    LightFace &operator=(const LightFace &) = delete;
    Status set(bool lit) override {
        device_->set_lit(lit);
        return ok();
    }
    bool lit() const override { return device_->lit(); }

private:
    std::shared_ptr<Device> device_;
};

} // namespace

std::int64_t MonotonicClock::now_ns() const {
    return monotonic_ns();
}

void MonotonicClock::sleep_until(std::int64_t t_ns) {
    timespec until{};
    until.tv_sec = t_ns / 1'000'000'000;
    until.tv_nsec = t_ns % 1'000'000'000;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
}

std::int64_t next_round_ns(std::int64_t now_ns, std::int64_t round_ns) {
    constexpr std::int64_t preparation_ns = 500'000'000;
    return ((now_ns + preparation_ns) / round_ns + 1) * round_ns;
}

Pairing pairing_of_delayed(double tof_delay_s, std::chrono::nanoseconds apart) {
    const std::chrono::nanoseconds delay(std::llround(1e9 * tof_delay_s));
    return {.tolerance = apart + std::chrono::abs(delay), .delay = delay};
}

Rig make_rig(std::unique_ptr<FrameSequence> sequence, const Playback &playback,
             std::shared_ptr<Clock> clock) {
    assert(playback.wake_latency_frames >= 0 && playback.frames >= 0);
    auto device = std::make_shared<Device>(std::move(sequence), playback, std::move(clock));
    return {std::make_unique<ColorFace>(device), std::make_unique<TofFace>(device),
            std::make_unique<LightFace>(device)};
}

} // namespace afterglow
