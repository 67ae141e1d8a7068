// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "core/base/unique_fd.hpp"
#include "drivers/source.hpp"
#include "drivers/timeouts.hpp"
#include "drivers/timestamps/v4l2_time.hpp"
#include "drivers/v4l2/buffer_queue.hpp"
#include "drivers/v4l2/negotiate.hpp"
#include "drivers/v4l2/system_calls.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace afterglow::v4l2 {

/// A frame in the driver's memory.
struct RawFrame {
    std::span<const std::uint8_t> bytes; ///< of the first plane
    std::int64_t t_ns = 0;
    std::uint64_t sequence = 0;
};

/// What happens to frames that arrived between two calls of next().
enum class Backlog {
    newest,  ///< all but the newest are skipped
    in_order ///< each is returned, oldest first
};

/// Streams a camera's frames.
///
///   stopped ─start()─▶ streaming ─device gone, errors, silence─▶ Capture::lost ─start()─▶ ...
///
/// The first frame after each start is skipped: it may be an old one with a new time stamp
/// (v4l2loopback), or half exposed. With Backlog::in_order, frames that have waited for longer than
/// 100 ms and two periods are skipped, too, while the time stamps are not believed. Called by the
/// estimator thread. next() allocates only to describe a problem.
class Stream {
public:
    /// `request.formats` must outlive the stream.
    Stream(SystemCalls &calls, FormatRequest request, Backlog backlog, const Timeouts &timeouts)
        : calls_(calls), request_(std::move(request)), backlog_(backlog), timeouts_(timeouts) {}

    /// Finds the device by its name, opens it and starts to stream.
    Result<FrameLayout> start();
    /// Stops to stream and closes the device; does nothing if it is stopped.
    void stop();

    /// Waits for a frame. Its bytes stay valid until release(), which must follow each
    /// Capture::frame.
    Capture next(RawFrame &frame, std::chrono::nanoseconds timeout);
    /// Gives the frame's memory back to the driver.
    void release();

    /// Records why a frame is unusable, and returns Capture::damaged.
    Capture damaged(std::string_view why);
    const std::string &problem() const { return problem_; }
    int fd() const { return fd_.get(); }

private:
    Capture accept(const v4l2_buffer &first, RawFrame &frame);
    /// Waits until a frame may be there (nothing), the time is over, or the camera lost.
    std::optional<Capture> wait(std::int64_t deadline_ns);
    bool has_time();
    Capture lost(int code);
    /// Gives the camera so much time, or three of its frames, from now on.
    void allow(std::chrono::nanoseconds silence);

    SystemCalls &calls_;
    const FormatRequest request_;
    const Backlog backlog_;
    const Timeouts timeouts_;

    UniqueFd fd_;
    std::optional<BufferQueue> queue_;
    std::optional<std::uint32_t> held_; ///< the buffer between next() and release()
    bool begun_ = false;                ///< whether the first frame has passed
    FrameCount count_;
    FrameClock clock_;
    std::int64_t period_ns_ = 0;
    std::int64_t filled_after_ns_ = 0; ///< frames in the driver's queue arrived after this
    std::int64_t stuck_at_ns_ = 0;     ///< if nothing comes before
    std::string problem_;
};

} // namespace afterglow::v4l2
