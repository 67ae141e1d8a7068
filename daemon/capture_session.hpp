// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.hpp"
#include "capture/frame_loop.hpp"
#include "daemon/outbox.hpp"
#include "ipc/ring_writer.hpp"

#include <chrono>
#include <cstdint>
#include <string_view>

namespace afterglow {

/// What the estimator thread is to do. One word, and the latest wins: however often clients change
/// their minds, nothing fills up and no order is lost.
struct alignas(4) Orders {
    GateMode mode = GateMode::automatic;
    bool run = false;  ///< somebody reads
    bool stop = false; ///< for good
};

/// Doubles from a quarter of a second to half of one: how long to leave a lost device alone.
class BackOff {
public:
    std::chrono::nanoseconds next();
    void reset() { delay_ = first; }

private:
    static constexpr std::chrono::nanoseconds first = std::chrono::milliseconds(250);
    static constexpr std::chrono::nanoseconds last = std::chrono::milliseconds(500);
    std::chrono::nanoseconds delay_ = first;
};

/// The cameras' life: started while somebody reads, published from, brought back when lost.
///
///   starting ─▶ running ◀─▶ tof-lost      any of them ─▶ idle ─▶ starting   nobody reads, or again
///                  ▲▼                     any of them ─▶ stopped            the recording is over
///              color-lost
///
/// Runs on the estimator thread; allocates nothing while the devices are well. Time is given by
/// the caller, so that tests need not wait.
class CaptureSession {
public:
    using Time = std::chrono::steady_clock::time_point;

    /// A wait that only new orders end.
    static constexpr auto for_ever = std::chrono::nanoseconds::max();
    /// How long an image is waited for at most, and so how late orders may be obeyed.
    static constexpr std::chrono::nanoseconds frame_timeout = std::chrono::milliseconds(100);
    /// A colour camera that gives no image for so long is stuck.
    static constexpr std::chrono::nanoseconds color_stall = std::chrono::seconds(3);
    /// So is a TOF camera that was lit for so long, and for so many images, without any answer.
    static constexpr std::chrono::nanoseconds tof_stall = std::chrono::seconds(5);
    static constexpr int tof_stall_frames = 120;

    CaptureSession(Rig &rig, const Config &config, WorkerPool &pool, RingWriter &ring,
                   Outbox &outbox);
    ~CaptureSession();
    CaptureSession(const CaptureSession &) = delete;
    CaptureSession &operator=(const CaptureSession &) = delete;

    /// Does what is due, one image at most, and returns how long nothing is until the next turn.
    std::chrono::nanoseconds turn(const Orders &orders, Time now);

private:
    std::chrono::nanoseconds rest();
    std::chrono::nanoseconds end();
    void start_tof(Time now);
    void take(const FrameResult &result, Time now);
    void publish(const FrameResult &result);
    void watch_tof(const FrameResult &result, Time now);
    std::chrono::nanoseconds lose_color(std::string_view why, Time now);
    void lose_tof(std::string_view why, Time now);
    void damaged(std::string_view why);

    const bool run_without_readers_;
    RingWriter &ring_;
    Outbox &outbox_;
    FrameLoop loop_;

    bool color_running_ = false;
    BackOff color_back_off_;
    Time color_retry_ = Time::min();
    Time last_image_;

    bool tof_running_ = false;
    bool tof_well_ = true; ///< not lost since it last measured
    BackOff tof_back_off_;
    Time tof_retry_ = Time::min();
    Time lit_since_;
    int lit_frames_ = 0; ///< images in a row, lit and without an answer

    bool ended_ = false;
    bool sequence_known_ = false;
    std::uint64_t next_sequence_ = 0;
    std::uint64_t damaged_since_image_ = 0;
    std::uint64_t damaged_ = 0;
    std::uint64_t missed_ = 0;
};

} // namespace afterglow
