// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/camera_id.hpp"
#include "drivers/libcamera/formats.hpp"
#include "drivers/libcamera/helper/helper.hpp"
#include "drivers/libcamera/wire.hpp"
#include "drivers/v4l2/device.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <libcamera/camera_manager.h>
#include <libcamera/control_ids.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/request.h>
#include <libcamera/stream.h>
#include <unistd.h>

namespace afterglow::libcam {
namespace {

using namespace libcamera;

/// A camera, from the looking for it to the end of the process.
class Capture {
public:
    explicit Capture(const CaptureRequest &wanted) : wish_(wanted) {}

    /// Streams; false, and said why, if that cannot be.
    bool start();
    /// Has buffers filled again as the other side releases them, until it is gone.
    void serve();

private:
    bool open();
    bool configure();
    bool make_requests();
    bool say_streaming();
    ControlList controls_for_rate();
    bool refused(std::string_view doing, int error);
    /// Called by libcamera's thread.
    void completed(Request *request);
    void disconnected();

    const CaptureRequest wish_;
    CameraManager manager_;
    std::shared_ptr<Camera> camera_;
    std::unique_ptr<CameraConfiguration> configuration_;
    std::unique_ptr<FrameBufferAllocator> allocator_;
    std::vector<std::unique_ptr<Request>> requests_; ///< one for each buffer, with its number
};

bool Capture::refused(std::string_view doing, int error) {
    const Error why = v4l2::device_error(wish_.id, doing, -error);
    say_failed(why.message, why.code);
    return false;
}

bool Capture::open() {
    if (const int error = manager_.start(); error < 0) {
        say_failed("libcamera does not start", -error);
        return false;
    }
    std::vector<std::string> ids;
    for (const std::shared_ptr<Camera> &camera : manager_.cameras())
        ids.push_back(camera->id());
    const Result<std::string> id = choose_id(ids, wish_.id);
    if (!id) {
        say_failed(id.error().message, id.error().code);
        return false;
    }
    camera_ = manager_.get(*id);
    if (!camera_)
        return refused("be found", -ENODEV);
    camera_->disconnected.connect(this, &Capture::disconnected);
    camera_->requestCompleted.connect(this, &Capture::completed);
    const int error = camera_->acquire();
    return error == 0 || refused("be acquired", error);
}

bool Capture::configure() {
    configuration_ = configuration(*camera_, wish_);
    if (!configuration_)
        return false;
    const int error = camera_->configure(configuration_.get());
    return error == 0 || refused("be configured", error);
}

bool Capture::make_requests() {
    Stream *stream = configuration_->at(0).stream();
    allocator_ = std::make_unique<FrameBufferAllocator>(camera_);
    if (const int count = allocator_->allocate(stream); count < 0)
        return refused("reserve buffers", count);
    const auto &buffers = allocator_->buffers(stream);
    const std::size_t count = std::min(buffers.size(), max_buffers);
    for (std::size_t i = 0; i < count; ++i) {
        requests_.push_back(camera_->createRequest(i));
        if (!requests_.back() || requests_.back()->addBuffer(stream, buffers[i].get()) != 0)
            return refused("use its buffers", -ENOMEM);
    }
    return true;
}

/// Frames as long as asked, where the camera lets that be told: else exposure may lengthen them.
ControlList Capture::controls_for_rate() {
    ControlList controls(camera_->controls());
    const auto limits = camera_->controls().find(&controls::FrameDurationLimits);
    if (limits == camera_->controls().end() ||
        limits->second.min().type() != ControlTypeInteger64 ||
        limits->second.max().type() != ControlTypeInteger64 || limits->second.min().isArray())
        return controls;
    const auto least = limits->second.min().get<std::int64_t>();
    const std::int64_t period = std::clamp(
        wish_.period_us, least, std::max(least, limits->second.max().get<std::int64_t>()));
    const std::array<std::int64_t, 2> both = {period, period};
    controls.set(controls::FrameDurationLimits, Span<const std::int64_t, 2>(both));
    return controls;
}

bool Capture::say_streaming() {
    const StreamConfiguration &stream = configuration_->at(0);
    Report report;
    report.kind = Report::Kind::streaming;
    report.fourcc = v4l2_code(stream.pixelFormat.fourcc());
    report.width = static_cast<std::int32_t>(stream.size.width);
    report.height = static_cast<std::int32_t>(stream.size.height);
    report.stride = stream.stride;
    report.buffer = static_cast<std::uint32_t>(requests_.size());
    std::vector<int> descriptors;
    for (const std::unique_ptr<Request> &request : requests_) {
        const FrameBuffer::Plane &luma = request->findBuffer(stream.stream())->planes().front();
        report.planes[descriptors.size()] = {luma.offset, luma.length};
        descriptors.push_back(luma.fd.get());
    }
    return send(helper_socket, report, descriptors);
}

bool Capture::start() {
    if (!open() || !configure() || !make_requests())
        return false;
    const ControlList controls = controls_for_rate();
    if (const int error = camera_->start(&controls); error != 0)
        return refused("begin to stream", error);
    if (!say_streaming())
        return false;
    for (const std::unique_ptr<Request> &request : requests_) {
        if (const int error = camera_->queueRequest(request.get()); error != 0)
            return refused("begin to stream", error);
    }
    return true;
}

void Capture::serve() {
    std::uint32_t number = 0;
    for (;;) {
        const ssize_t got = ::recv(helper_socket, &number, sizeof number, 0);
        if (got < 0 && errno == EINTR)
            continue;
        if (got != static_cast<ssize_t>(sizeof number) || number >= requests_.size())
            return;
        requests_[number]->reuse(Request::ReuseBuffers);
        if (camera_->queueRequest(requests_[number].get()) == -ENODEV)
            return disconnected();
    }
}

void Capture::completed(Request *request) {
    if (request->status() != Request::RequestComplete)
        return; // cancelled: the camera has gone, or the stream has ended
    const FrameMetadata &frame = request->buffers().begin()->second->metadata();
    const auto stamp = request->metadata().get(controls::SensorTimestamp);
    Report report;
    report.kind =
        frame.status == FrameMetadata::FrameSuccess ? Report::Kind::frame : Report::Kind::damaged;
    report.buffer = static_cast<std::uint32_t>(request->cookie());
    report.bytes = frame.planes()[0].bytesused;
    report.sequence = frame.sequence;
    report.begins_exposure = stamp.has_value();
    report.stamp_ns = stamp.value_or(static_cast<std::int64_t>(frame.timestamp));
    report.arrival_ns =
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    const bool is_worth_saying =
        frame.status == FrameMetadata::FrameSuccess || frame.status == FrameMetadata::FrameError;
    if (is_worth_saying && !send(helper_socket, report))
        ::_exit(0);
    if (frame.status == FrameMetadata::FrameSuccess)
        return;
    request->reuse(Request::ReuseBuffers);
    camera_->queueRequest(request);
}

void Capture::disconnected() {
    say_failed(fmt::format("the camera '{}' was unplugged", wish_.id), ENODEV);
    ::_exit(0);
}

} // namespace

void say_failed(std::string_view sentence, int code) {
    Report report;
    report.kind = Report::Kind::failed;
    report.code = code;
    report.set_text(sentence);
    send(helper_socket, report);
}

void capture(const CaptureRequest &wanted) {
    Capture capture(wanted);
    if (capture.start())
        capture.serve();
    // Nor are its members destroyed: that can hang, or abort.
    ::_exit(0);
}

} // namespace afterglow::libcam
