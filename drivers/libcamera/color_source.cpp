// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "drivers/libcamera/buffers.hpp"
#include "drivers/libcamera/formats.hpp"
#include "drivers/libcamera/helper_process.hpp"
#include "drivers/libcamera/libcamera.hpp"
#include "drivers/timeouts.hpp"
#include "drivers/timestamps/libcamera_time.hpp"
#include "drivers/timestamps/v4l2_time.hpp"
#include "drivers/v4l2/luma_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/socket.h>

#include <cassert>
#include <cerrno>
#include <cmath>
#include <optional>
#include <utility>

namespace afterglow {
namespace {

using namespace libcam;
using Time = std::chrono::steady_clock::time_point;
using Kind = Report::Kind;

Time now() {
    return std::chrono::steady_clock::now();
}

/// Whether a frame comes after those that were taken later. libcamera gives frames in the order in
/// which it gave the buffers to the driver, but uvcvideo puts a buffer with a bad frame behind the
/// others: what they hold is kept back until it is full too.
bool comes_late(std::uint32_t number, const std::optional<std::uint32_t> &newest) {
    const std::uint32_t behind = newest.value_or(number) - number; // modulo 2^32
    return behind > 0 && behind <= max_buffers;
}

///   stopped ─start()─▶ streaming ─failure, end or silence of the helper─▶ Capture::lost ─start()─▶
///
/// As with V4L2 the first frame after each start is passed over.
class LibcameraColor final : public ColorSource {
public:
    LibcameraColor(const LibcameraColorOptions &options, const std::vector<std::uint32_t> &formats,
                   std::string helper)
        : device_(options.device), camera_(options.camera),
          period_ns_(std::llround(1e9 / options.fps)),
          helper_(std::move(helper)), arguments_{"capture",
                                                 options.device,
                                                 std::to_string(options.camera.width),
                                                 std::to_string(options.camera.height),
                                                 std::to_string(period_ns_ / 1000),
                                                 fmt::format("{}", fmt::join(formats, ","))} {}

    const Intrinsics &intrinsics() const override { return camera_; }
    Status start() override;
    void stop() override;
    Capture read(ColorFrame &frame, std::chrono::nanoseconds timeout) override;
    const std::string &problem() const override { return problem_; }

private:
    Status await_streaming();
    /// The newest of the images that have come, if one has; those before it are passed over. False
    /// if the camera is lost.
    bool take_newest(std::optional<Report> &newest);
    Capture accept(const Report &report, ColorFrame &frame);
    void release(const Report &frame);
    Capture lost(std::string_view why);
    Capture damaged(std::string_view why);

    const std::string device_;
    const Intrinsics camera_;
    const std::int64_t period_ns_;
    const std::string helper_;
    const std::vector<std::string> arguments_;
    const Timeouts timeouts_;

    std::optional<HelperProcess> process_;
    Buffers buffers_;
    v4l2::LumaReader reader_;
    bool begun_ = false; ///< whether the first frame has passed
    v4l2::FrameCount count_;
    std::optional<std::uint32_t> last_number_; ///< the camera's own, of the newest report
    std::uint64_t sequence_ = 0;               ///< the same as count_ has it
    Time stuck_at_;                            ///< if nothing comes before
    std::vector<UniqueFd> descriptors_;
    std::string problem_;
};

Status LibcameraColor::start() {
    stop();
    Result<HelperProcess> process = HelperProcess::start(helper_, arguments_);
    if (!process)
        return process.error();
    process_.emplace(*std::move(process));
    Status streaming = await_streaming();
    if (!streaming)
        stop();
    return streaming;
}

Status LibcameraColor::await_streaming() {
    Report report;
    switch (process_->await(report, descriptors_, now() + timeouts_.first_frame)) {
    case Received::nothing:
        return Error{
            fmt::format("libcamera does not answer about the camera '{}'", printable(device_)),
            ETIMEDOUT};
    case Received::end:
        return Error{
            fmt::format("libcamera's process ended at the camera '{}'", printable(device_)), EIO};
    case Received::message:
        break;
    }
    if (report.kind == Kind::failed)
        return Error{printable(report.text.data()), report.code};
    if (report.kind == Kind::streaming && report.width == camera_.width &&
        report.height == camera_.height)
        buffers_ = Buffers(report, std::exchange(descriptors_, {}));
    if (buffers_.count() == 0)
        return Error{
            fmt::format("the images of the camera '{}' cannot be shared", printable(device_)), EIO};
    v4l2::FrameLayout layout;
    layout.fourcc = report.fourcc;
    layout.width = report.width;
    layout.height = report.height;
    layout.stride = report.stride;
    reader_ = v4l2::make_luma_reader(layout, -1);
    begun_ = false;
    count_ = v4l2::FrameCount();
    last_number_.reset();
    stuck_at_ = now() + Timeouts::with(timeouts_.first_frame, period_ns_);
    return ok();
}

void LibcameraColor::stop() {
    process_.reset();
    buffers_ = Buffers();
    reader_ = nullptr;
}

Capture LibcameraColor::read(ColorFrame &frame, std::chrono::nanoseconds timeout) {
    assert(process_);
    const Time deadline = now() + timeout;
    for (;;) {
        std::optional<Report> newest;
        if (!take_newest(newest))
            return Capture::lost;
        if (newest)
            return accept(*newest, frame);
        const Time t = now();
        if (t >= stuck_at_)
            return lost("gives no images");
        if (t >= deadline)
            return Capture::none;
        process_->wait(std::min(deadline, stuck_at_) - t);
    }
}

bool LibcameraColor::take_newest(std::optional<Report> &newest) {
    Report report;
    for (;;) {
        switch (receive(process_->socket(), report, descriptors_)) {
        case Received::nothing:
            return true;
        case Received::end:
            lost("was lost: libcamera's process ended");
            return false;
        case Received::message:
            break;
        }
        if (report.kind == Kind::failed) {
            problem_ = printable(report.text.data());
            return false;
        }
        const bool is_frame = report.kind == Kind::frame && report.buffer < buffers_.count();
        if (!is_frame && report.kind != Kind::damaged) {
            lost("was lost: libcamera's process is not understood");
            return false;
        }
        const bool is_first = !std::exchange(begun_, true);
        if (is_first || comes_late(report.sequence, last_number_)) {
            release(report);
            continue;
        }
        if (newest)
            release(*newest);
        newest = report;
        last_number_ = report.sequence;
        sequence_ = count_.next(report.sequence);
    }
}

Capture LibcameraColor::accept(const Report &report, ColorFrame &frame) {
    stuck_at_ = now() + Timeouts::with(timeouts_.next_frame, period_ns_);
    frame.sequence = sequence_;
    if (report.kind == Kind::damaged)
        return damaged("libcamera marks it as bad");
    if (frame.luma.width() != camera_.width || frame.luma.height() != camera_.height)
        frame.luma = {camera_.width, camera_.height};
    const std::string_view wrong = buffers_.read(
        report, [&](std::span<const std::uint8_t> bytes) { return reader_(bytes, frame.luma); });
    release(report);
    if (!wrong.empty())
        return damaged(wrong);
    frame.t_ns = capture_time({report.stamp_ns, report.begins_exposure, report.arrival_ns},
                              period_ns_, time_asleep_ns());
    return Capture::frame;
}

void LibcameraColor::release(const Report &frame) {
    // A helper that cannot take it has ended, or does not go on: the next frame will show which.
    if (frame.kind == Kind::frame)
        ::send(process_->socket(), &frame.buffer, sizeof frame.buffer, MSG_DONTWAIT | MSG_NOSIGNAL);
}

Capture LibcameraColor::lost(std::string_view why) {
    problem_ = fmt::format("the camera '{}' {}", printable(device_), why);
    return Capture::lost;
}

Capture LibcameraColor::damaged(std::string_view why) {
    problem_ = fmt::format("an image of the camera '{}' is dropped: {}", printable(device_), why);
    return Capture::damaged;
}

} // namespace

Result<std::unique_ptr<ColorSource>> open_libcamera_color(const LibcameraColorOptions &options,
                                                          const std::string &helper) {
    const Result<std::vector<std::uint32_t>> formats = v4l2::formats_wanted(
        options.device, options.camera, options.fps, options.format, readable_formats());
    if (!formats)
        return formats.error();
    return std::unique_ptr<ColorSource>(
        std::make_unique<LibcameraColor>(options, *formats, helper));
}

} // namespace afterglow
