// SPDX-License-Identifier: Apache-2.0
#include "tools/testcam/depth_stream.hpp"

#include "core/base/clock.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace afterglow::testcam {
namespace {

/// What a light that has not settled does to a map: it seems nearer, and half of it is missing.
void spoil(ImageView<std::uint16_t> depth) {
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u)
            depth(u, v) = static_cast<std::uint16_t>(u % 2 == 0 ? 0 : depth(u, v) * 4 / 5);
}

float field_of_view(double focal_length, int side) {
    return static_cast<float>(2 * std::atan2(side / 2.0, focal_length));
}

} // namespace

DepthStream::DepthStream(const Settings &settings, DepthSequence &sequence, Emitter &emitter,
                         const std::atomic<bool> &frozen)
    : clock_rate_(1 + settings.drift_ppm * 1e-6), sequence_(sequence), emitter_(emitter),
      frozen_(frozen), mode_(mode_of(sequence)),
      ahead_(sequence.camera().width, sequence.camera().height) {}

OniVideoMode DepthStream::mode_of(const DepthSequence &sequence) {
    return {ONI_PIXEL_FORMAT_DEPTH_1_MM, sequence.camera().width, sequence.camera().height,
            std::max(static_cast<int>(std::lround(sequence.fps())), 1)};
}

OniStatus DepthStream::start() {
    stop();
    running_ = true;
    emitter_.set_streaming(true);
    thread_ = std::thread([this] { run(); });
    return ONI_STATUS_OK;
}

void DepthStream::stop() {
    {
        const std::lock_guard lock(mutex_);
        running_ = false;
    }
    wake_.notify_one();
    if (thread_.joinable())
        thread_.join();
    emitter_.set_streaming(false);
}

void DepthStream::run() {
    using Time = std::chrono::steady_clock::time_point;
    Rounds::Frame frame = sequence_.next(monotonic_ns());
    std::unique_lock lock(mutex_);
    while (running_) {
        const Time due{std::chrono::nanoseconds(frame.due_ns)};
        lock.unlock();
        if (emitter_.is_lit())
            read_ahead(frame.number);
        lock.lock();
        if (wake_.wait_until(lock, due, [this] { return !running_; }))
            break;
        lock.unlock();
        ++index_;
        if (!frozen_)
            if (const Light light = emitter_.expose(frame.due_ns, frame.number);
                light != Light::dark)
                give(frame, light);
        frame = sequence_.next(std::max(frame.due_ns, monotonic_ns()));
        lock.lock();
    }
}

void DepthStream::read_ahead(std::uint64_t number) {
    if (ahead_number_ != number)
        ahead_number_.reset();
    if (!ahead_number_ && sequence_.read(number, ahead_))
        ahead_number_ = number;
}

void DepthStream::give(const Rounds::Frame &frame, Light light) {
    OniFrame *out = getServices().acquireFrame();
    if (out == nullptr)
        return;
    const ImageView<std::uint16_t> depth(static_cast<std::uint16_t *>(out->data), mode_.resolutionX,
                                         mode_.resolutionY);
    read_ahead(frame.number);
    if (ahead_number_) {
        for (int v = 0; v < depth.height(); ++v)
            std::copy_n(ahead_.row(v), depth.width(), depth.row(v));
        if (light == Light::settling)
            spoil(depth);
        out->frameIndex = index_;
        out->videoMode = mode_;
        out->width = mode_.resolutionX;
        out->height = mode_.resolutionY;
        out->cropOriginX = out->cropOriginY = 0;
        out->croppingEnabled = FALSE;
        out->sensorType = ONI_SENSOR_DEPTH;
        out->stride = 2 * mode_.resolutionX;
        out->dataSize = out->stride * mode_.resolutionY;
        out->timestamp =
            static_cast<std::uint64_t>(static_cast<double>(frame.due_ns) * clock_rate_ / 1'000);
        raiseNewFrame(out);
    }
    getServices().releaseFrame(out);
}

OniBool DepthStream::isPropertySupported(int property) {
    switch (property) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
    case ONI_STREAM_PROPERTY_MIRRORING:
    case ONI_STREAM_PROPERTY_MAX_VALUE:
    case ONI_STREAM_PROPERTY_MIN_VALUE:
    // The library plays no recording of a stream that does not answer these two.
    case ONI_STREAM_PROPERTY_STRIDE:
    case ONI_STREAM_PROPERTY_CROPPING:
        return TRUE;
    default:
        return FALSE;
    }
}

OniStatus DepthStream::getProperty(int property, void *data, int *size) {
    const Intrinsics &camera = sequence_.camera();
    switch (property) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return answer(mode_, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return answer(field_of_view(camera.fx, camera.width), data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return answer(field_of_view(camera.fy, camera.height), data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
        return answer(mirrored_, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
        return answer(65535, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
        return answer(0, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
        return answer(2 * mode_.resolutionX, data, size);
    case ONI_STREAM_PROPERTY_CROPPING:
        return answer(OniCropping{FALSE, 0, 0, mode_.resolutionX, mode_.resolutionY}, data, size);
    default:
        return ONI_STATUS_NOT_IMPLEMENTED;
    }
}

OniStatus DepthStream::setProperty(int property, const void *data, int size) {
    if (property == ONI_STREAM_PROPERTY_VIDEO_MODE && size == sizeof(OniVideoMode)) {
        const auto &wanted = *static_cast<const OniVideoMode *>(data);
        const bool same = wanted.pixelFormat == mode_.pixelFormat &&
                          wanted.resolutionX == mode_.resolutionX &&
                          wanted.resolutionY == mode_.resolutionY && wanted.fps == mode_.fps;
        return same ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
    }
    // Of a camera that cannot mirror only the refusal is useful.
    if (property == ONI_STREAM_PROPERTY_MIRRORING && size == sizeof(OniBool))
        return *static_cast<const OniBool *>(data) == FALSE ? ONI_STATUS_OK
                                                            : ONI_STATUS_NOT_SUPPORTED;
    return ONI_STATUS_NOT_IMPLEMENTED;
}

} // namespace afterglow::testcam
