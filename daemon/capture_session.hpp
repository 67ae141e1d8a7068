// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/frame_loop.hpp"
#include "config/config.hpp"
#include "daemon/calibration_notes.hpp"
#include "daemon/outbox.hpp"
#include "ipc/ring/ring_writer.hpp"
#include "ipc/ring/stream_notifier.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace afterglow {

/// What the estimator thread is to do. Only the latest value counts, so no queue can fill up,
/// however often clients change the policy.
struct Orders {
    GatePolicy policy = {};
    std::optional<RigGeometry> geometry = {}; ///< calibration; nothing: as at the start
    std::uint64_t measurements = 0;           ///< asked for so far: one more wants one more
    double linger_s = 0; ///< that the cameras go on after the last stream's end
    bool run = false;    ///< a stream is open
    bool stop = false;   ///< end the thread
};

/// The delay before a lost device is started again: 250 ms, then 500 ms.
class BackOff {
public:
    std::chrono::nanoseconds next();
    void reset() { delay_ = first; }

private:
    static constexpr std::chrono::nanoseconds first = std::chrono::milliseconds(250);
    static constexpr std::chrono::nanoseconds last = std::chrono::milliseconds(500);
    std::chrono::nanoseconds delay_ = first;
};

/// Starts the cameras while a stream is open, publishes their frames, and restarts lost ones.
///
///   starting ─▶ running ◀─▶ tof-lost      any of them ─▶ idle ─▶ starting   no stream, or again
///                  ▲▼                     any of them ─▶ stopped            the recording is over
///              color-lost
///
/// The cameras go on for Orders::linger_s after the last stream's end, so that a reader
/// that comes back finds them tracking. When they fall asleep the ring is cleared.
///
/// Runs on the estimator thread; allocates nothing while no device fails. The caller passes the
/// time, so that tests need not wait.
class CaptureSession {
public:
    using Time = std::chrono::steady_clock::time_point;

    /// The return value of turn() when only new orders give work.
    static constexpr auto for_ever = std::chrono::nanoseconds::max();
    /// The longest wait for an image, and so the longest delay of an order.
    static constexpr std::chrono::nanoseconds frame_timeout = std::chrono::milliseconds(100);
    /// A colour camera without an image for this long is restarted.
    static constexpr std::chrono::nanoseconds color_stall = std::chrono::seconds(3);
    /// So is a TOF camera that was lit for this long, and for this many images, without a map.
    static constexpr std::chrono::nanoseconds tof_stall = std::chrono::seconds(5);
    static constexpr int tof_stall_frames = 120;

    CaptureSession(Rig &rig, const Config &config, WorkerPool &pool, RingWriter &ring,
                   const StreamNotifier &streams, Outbox &outbox);
    ~CaptureSession();
    CaptureSession(const CaptureSession &) = delete;
    CaptureSession &operator=(const CaptureSession &) = delete;

    /// Does what is due, reading one image at most. Returns how long to wait before the next call.
    std::chrono::nanoseconds turn(const Orders &orders, Time now);

private:
    void obey(const Orders &orders);
    bool wanted(const Orders &orders, Time now);
    std::chrono::nanoseconds rest();
    std::chrono::nanoseconds end();
    void tell(CameraState color);
    void start_tof(Time now);
    void take(const FrameResult &result, Time now);
    void publish(const FrameResult &result);
    /// Adds the time since the image before to stream_ns_ and the CPU time in it to cpu_ns_.
    void charge(std::int64_t t_ns);
    void watch_tof(const FrameResult &result, Time now);
    std::chrono::nanoseconds lose_color(std::string_view why, Time now);
    void lose_tof(std::string_view why, Time now);
    void damaged(std::string_view why);

    Rig &rig_;
    const bool run_without_readers_;
    WorkerPool &pool_;
    RingWriter &ring_;
    const StreamNotifier &streams_;
    Outbox &outbox_;
    FrameLoop loop_;

    std::uint64_t measurements_ordered_ = 0;
    Time wanted_until_ = Time::min(); ///< a stream was open, and the linger after it
    bool first_ = true;               ///< no frame yet since the cameras were started
    std::uint32_t calibration_ = 1;
    CalibrationNotes calibration_notes_;

    bool color_running_ = false;
    BackOff color_back_off_;
    Time color_retry_ = Time::min();
    Time last_image_;

    bool tof_running_ = false;
    bool tof_well_ = true; ///< false from a loss to the next measurement
    BackOff tof_back_off_;
    Time tof_retry_ = Time::min();
    Time lit_since_;
    int lit_frames_ = 0; ///< consecutive images that were lit and have no map

    bool ended_ = false;
    bool sequence_known_ = false;
    std::uint64_t next_sequence_ = 0;
    std::uint64_t damaged_since_image_ = 0;
    FrameLosses losses_;

    std::uint32_t skipped_ = 0;     ///< images since the last frame that had none
    std::uint32_t skipped_lit_ = 0; ///< those with light

    std::uint64_t measurements_ = 0;
    std::int64_t measurement_t_ns_ = 0; ///< of the last one, on the images' clock
    std::uint64_t tof_sequence_ = 0;    ///< of the same

    std::optional<std::int64_t> charged_t_ns_; ///< of the image before; none: the cameras slept
    std::int64_t charged_cpu_ns_ = 0;          ///< of the process at that image
    std::int64_t stream_ns_ = 0;
    std::int64_t cpu_ns_ = 0;
};

} // namespace afterglow
