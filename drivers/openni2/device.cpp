// SPDX-License-Identifier: Apache-2.0
#include "core/base/clock.hpp"
#include "core/base/log.hpp"
#include "core/base/printable.hpp"
#include "drivers/openni2/depth_mode.hpp"
#include "drivers/openni2/library.hpp"
#include "drivers/openni2/openni2.hpp"
#include "drivers/timestamps/device_clock.hpp"

#include <fmt/format.h>

#include <OpenNI.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>

namespace afterglow {

namespace {

/// More than two frames at 30 FPS.
constexpr auto player_pause = std::chrono::milliseconds(100);

/// Copies a frame's pixels as millimetres. False if it is not of the camera's size.
bool copy_depth(const openni::VideoFrameRef &frame, DepthMap &depth) {
    if (frame.getWidth() != depth.width() || frame.getHeight() != depth.height() ||
        !openni2::is_depth(frame.getVideoMode()) || frame.getStrideInBytes() < 2 * depth.width() ||
        frame.getDataSize() < frame.getStrideInBytes() * (depth.height() - 1) + 2 * depth.width())
        return false;
    const int units = openni2::units_per_mm(frame.getVideoMode());
    const auto *row = static_cast<const std::uint8_t *>(frame.getData());
    for (int v = 0; v < depth.height(); ++v, row += frame.getStrideInBytes()) {
        const auto *from = reinterpret_cast<const std::uint16_t *>(row);
        if (units == 1)
            std::copy_n(from, depth.width(), depth.row(v));
        else
            std::transform(from, from + depth.width(), depth.row(v), [&](std::uint16_t value) {
                return static_cast<std::uint16_t>((value + units / 2) / units);
            });
    }
    return true;
}

} // namespace

struct OpenNi2Device::Impl : openni::OpenNI::DeviceDisconnectedListener,
                             openni::VideoStream::NewFrameListener {
    explicit Impl(OpenNi2Options wanted) : options(std::move(wanted)) {
        arrived.depth = DepthMap(options.camera.width, options.camera.height);
    }

    std::string name() const { return options.uri.empty() ? "any" : printable(options.uri); }
    Error refused(const char *what) const {
        return openni2::library_error(
            fmt::format("the OpenNI2 device '{}' cannot {}", name(), what).c_str());
    }
    Status open_device();
    Status open_stream();
    void close();
    Status set_emitter(bool lit);
    void forget_arrived();
    Capture lost(std::string_view why);
    void onDeviceDisconnected(const openni::DeviceInfo *info) override;
    void onNewFrame(openni::VideoStream &from) override;

    const OpenNi2Options options;
    bool listens = false; ///< to the library

    /// Held while the device is opened, closed or told about its light.
    std::mutex device_mutex;
    openni::Device device;
    bool is_open = false;
    int emitter_property = 0; ///< 0: the light is not the emitter's
    int emitter_size = 0;

    /// Held while a frame is awaited, and while the stream is started or stopped.
    std::mutex stream_mutex;
    openni::VideoStream stream;
    bool streaming = false;
    bool hears_frames = false;
    int frames_in_file = 0; ///< 0: it is no recording, or one without depth

    /// The newest frame. The library's thread takes it, for it may be read much later than it came.
    struct Arrived {
        bool is_new = false;
        bool is_good = false;       ///< or else not as the device was told
        DepthMap depth;             ///< of the camera's size
        std::int64_t device_ns = 0; ///< on the device's own clock
        std::int64_t arrival_ns = 0;
        int index = 0;
    };
    std::mutex arrived_mutex;
    std::condition_variable arrival;
    Arrived arrived;

    /// The library's own thread says so.
    std::mutex uri_mutex;
    std::string open_uri;
    std::atomic<bool> gone = false;

    DeviceClock clock;
    std::string problem;
};

Status OpenNi2Device::Impl::open_device() {
    if (Status loaded = openni2::load_library(); !loaded)
        return loaded;
    if (!listens)
        openni::OpenNI::addDeviceDisconnectedListener(this);
    listens = true;
    gone = false;
    if (device.open(options.uri.empty() ? openni::ANY_DEVICE : options.uri.c_str()) !=
        openni::STATUS_OK)
        return refused("be opened");
    {
        const std::lock_guard lock(uri_mutex);
        open_uri = device.getDeviceInfo().getUri();
    }
    clock = DeviceClock();
    is_open = true;
    return ok();
}

Status OpenNi2Device::Impl::open_stream() {
    if (options.registration) {
        if (!device.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR))
            return Error{fmt::format("the OpenNI2 device '{}' cannot register its depth to its "
                                     "colour camera (registration = false takes it as it is)",
                                     name()),
                         ENOTSUP};
        if (device.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR) !=
            openni::STATUS_OK)
            return refused("register its depth to its colour camera");
    }
    if (stream.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK)
        return refused("give depth");
    const auto mode =
        openni2::choose_mode(stream.getSensorInfo().getSupportedVideoModes(), options);
    if (!mode)
        return Error{fmt::format("the OpenNI2 device '{}' has no depth of {}x{}", name(),
                                 options.camera.width, options.camera.height),
                     EINVAL};
    if (stream.setVideoMode(*mode) != openni::STATUS_OK && !device.isFile())
        return refused("be set to its own mode");
    if (stream.isPropertySupported(openni::STREAM_PROPERTY_MIRRORING) &&
        stream.setMirroringEnabled(false) != openni::STATUS_OK && !device.isFile())
        return refused("leave its depth unmirrored");
    forget_arrived();
    if (stream.addNewFrameListener(this) != openni::STATUS_OK)
        return refused("tell of its frames");
    hears_frames = true;
    frames_in_file = 0;
    if (openni::PlaybackControl *playback = device.getPlaybackControl()) {
        // Begun again by the library, its times would jump back.
        if (playback->setRepeatEnabled(false) != openni::STATUS_OK)
            return refused("be played once");
        frames_in_file = playback->getNumberOfFrames(stream);
    }
    return ok();
}

void OpenNi2Device::Impl::close() {
    const std::lock_guard lock(stream_mutex);
    streaming = false;
    if (std::exchange(hears_frames, false))
        stream.removeNewFrameListener(this);
    if (frames_in_file > 0) {
        stream.stop();
        // The library's player looks at its streams without a lock, over and over at a recording's
        // end, and crashes if one goes meanwhile. Stopped, it sleeps nearly all the time, once the
        // frame is over that it may be waiting for.
        std::this_thread::sleep_for(player_pause);
    }
    stream.destroy();
    device.close();
    is_open = false;
}

Status OpenNi2Device::Impl::set_emitter(bool lit) {
    const std::uint64_t value = lit ? 1 : 0; // little-endian: the first bytes are the value
    if (device.setProperty(emitter_property, &value, emitter_size) != openni::STATUS_OK)
        return refused("switch its emitter");
    return ok();
}

Capture OpenNi2Device::Impl::lost(std::string_view why) {
    problem = fmt::format("the OpenNI2 device '{}' {}", name(), why);
    return Capture::lost;
}

void OpenNi2Device::Impl::onNewFrame(openni::VideoStream &from) {
    const std::int64_t now = monotonic_ns();
    // One call may stand for two frames, and then the second has none to read, for which the
    // library would wait.
    openni::VideoStream *waited = &from;
    int ready = 0;
    openni::VideoFrameRef frame;
    if (openni::OpenNI::waitForAnyStream(&waited, 1, &ready, 0) != openni::STATUS_OK ||
        from.readFrame(&frame) != openni::STATUS_OK)
        return;
    const std::lock_guard lock(arrived_mutex);
    arrived.is_new = true;
    arrived.is_good = copy_depth(frame, arrived.depth);
    arrived.device_ns = static_cast<std::int64_t>(frame.getTimestamp()) * 1'000;
    arrived.arrival_ns = now;
    arrived.index = frame.getFrameIndex();
    arrival.notify_one();
}

void OpenNi2Device::Impl::forget_arrived() {
    const std::lock_guard lock(arrived_mutex);
    arrived.is_new = false;
    arrived.index = 0;
}

void OpenNi2Device::Impl::onDeviceDisconnected(const openni::DeviceInfo *info) {
    const std::lock_guard lock(uri_mutex);
    if (open_uri == info->getUri())
        gone = true;
}

OpenNi2Device::OpenNi2Device(OpenNi2Options options)
    : impl_(std::make_unique<Impl>(std::move(options))) {}

OpenNi2Device::~OpenNi2Device() {
    stop();
    if (impl_->listens)
        openni::OpenNI::removeDeviceDisconnectedListener(impl_.get());
}

const Intrinsics &OpenNi2Device::intrinsics() const {
    return impl_->options.camera;
}

const std::string &OpenNi2Device::problem() const {
    return impl_->problem;
}

Status OpenNi2Device::start() {
    const std::lock_guard lock(impl_->device_mutex);
    if (impl_->is_open)
        impl_->close();
    Status opened = impl_->open_device();
    if (opened)
        opened = impl_->open_stream();
    if (opened && !impl_->options.stream_is_light) {
        if (impl_->stream.start() != openni::STATUS_OK)
            opened = impl_->refused("stream");
        impl_->streaming = static_cast<bool>(opened);
        // Devices light their emitter when they begin to stream.
        if (opened && impl_->emitter_property != 0)
            opened = impl_->set_emitter(false);
    }
    if (!opened && impl_->is_open)
        impl_->close();
    return opened;
}

void OpenNi2Device::stop() {
    const std::lock_guard lock(impl_->device_mutex);
    if (!impl_->is_open)
        return;
    // A device that keeps its emitter's state is left dark; one that has gone cannot be told.
    if (impl_->emitter_property != 0 && !impl_->gone)
        if (const Status dark = impl_->set_emitter(false); !dark)
            log(Priority::error, "the illuminator may still be lit: " + dark.error().message);
    impl_->close();
}

Status OpenNi2Device::darken() {
    const std::lock_guard lock(impl_->device_mutex);
    if (Status opened = impl_->open_device(); !opened)
        return opened;
    Status dark = impl_->emitter_property != 0 ? impl_->set_emitter(false) : ok();
    impl_->close();
    return dark;
}

Capture OpenNi2Device::read(DepthFrame &frame, std::chrono::nanoseconds timeout) {
    Impl &it = *impl_;
    if (it.gone)
        return it.lost("was unplugged");
    const std::unique_lock lock(it.stream_mutex, std::try_to_lock);
    if (!lock.owns_lock() || !it.streaming)
        return Capture::none;
    std::unique_lock arrived_lock(it.arrived_mutex);
    if (!it.arrival.wait_for(arrived_lock, timeout, [&] { return it.arrived.is_new; })) {
        if (it.frames_in_file == 0 || it.arrived.index < it.frames_in_file)
            return Capture::none;
        it.problem = fmt::format("the recording '{}' is over", it.name());
        return Capture::lost;
    }
    it.arrived.is_new = false;
    if (!it.arrived.is_good) {
        it.problem = fmt::format("a frame of the OpenNI2 device '{}' is dropped: it is not as the "
                                 "device was told",
                                 it.name());
        return Capture::damaged;
    }
    frame.depth = it.arrived.depth;
    frame.t_ns = it.clock.to_monotonic(it.arrived.device_ns, it.arrived.arrival_ns);
    frame.sequence = static_cast<std::uint64_t>(it.arrived.index);
    return Capture::frame;
}

Status OpenNi2Device::set_emitter(int property, int size, bool lit) {
    const std::lock_guard lock(impl_->device_mutex);
    impl_->emitter_property = property;
    impl_->emitter_size = size;
    if (!impl_->is_open || impl_->gone)
        return lit ? Status(Error{"the OpenNI2 device with the light is not there", ENODEV}) : ok();
    return impl_->set_emitter(lit);
}

Status OpenNi2Device::set_streaming(bool running) {
    const std::lock_guard lock(impl_->device_mutex);
    if (!impl_->is_open || impl_->gone)
        return running ? Status(Error{"the OpenNI2 device with the light is not there", ENODEV})
                       : ok();
    const std::lock_guard stream_lock(impl_->stream_mutex);
    if (running) {
        impl_->forget_arrived();
        if (impl_->stream.start() != openni::STATUS_OK)
            return impl_->refused("stream");
    }
    if (!running)
        impl_->stream.stop();
    impl_->streaming = running;
    return ok();
}

} // namespace afterglow
