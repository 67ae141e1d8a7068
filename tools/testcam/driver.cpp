// SPDX-License-Identifier: Apache-2.0
// afterglow-testcam: an OpenNI2 driver whose one device is a TOF camera that plays depth. It needs
// no hardware; tools/testcam/settings.hpp says what it can be told.
#include "core/base/unique_fd.hpp"
#include "tools/testcam/depth_stream.hpp"

#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <string>
#include <unistd.h>

namespace afterglow::testcam {
namespace {

constexpr const char *uri = "testcam://0";
/// The emitters of PS1080 and PSLink devices, and the payloads that they insist on.
constexpr int ps1080_emitter = 0x1080E007;
constexpr int pslink_emitter = 0x12000008;

class TestDevice final : public oni::driver::DeviceBase {
public:
    TestDevice(const Settings &settings, std::unique_ptr<DepthSequence> sequence,
               const std::atomic<bool> &frozen)
        : settings_(settings), sequence_(std::move(sequence)), emitter_(settings), frozen_(frozen),
          mode_(DepthStream::mode_of(*sequence_)), sensor_{ONI_SENSOR_DEPTH, 1, &mode_} {}

    OniStatus getSensorInfoList(OniSensorInfo **sensors, int *count) override {
        *sensors = &sensor_;
        *count = 1;
        return ONI_STATUS_OK;
    }
    oni::driver::StreamBase *createStream(OniSensorType type) override {
        return type == ONI_SENSOR_DEPTH ? new DepthStream(settings_, *sequence_, emitter_, frozen_)
                                        : nullptr;
    }
    void destroyStream(oni::driver::StreamBase *stream) override { delete stream; }

    OniStatus getProperty(int property, void *data, int *size) override {
        if (property == ONI_DEVICE_PROPERTY_DRIVER_VERSION)
            return answer(OniVersion{1, 0, 0, 0}, data, size);
        return ONI_STATUS_NOT_IMPLEMENTED;
    }
    OniStatus setProperty(int property, const void *data, int size) override {
        if (property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION)
            return ONI_STATUS_OK; // its depth is registered as recorded
        const bool is_ps1080 = property == ps1080_emitter && size == sizeof(std::uint64_t);
        const bool is_pslink = property == pslink_emitter && size == sizeof(std::int32_t);
        if (!is_ps1080 && !is_pslink)
            return ONI_STATUS_BAD_PARAMETER;
        std::uint64_t state = 0;
        std::memcpy(&state, data, static_cast<std::size_t>(size));
        emitter_.set_on(state != 0);
        return ONI_STATUS_OK;
    }
    OniBool isPropertySupported(int property) override {
        return property == ps1080_emitter || property == pslink_emitter ||
               property == ONI_DEVICE_PROPERTY_DRIVER_VERSION ||
               property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
    }
    OniBool isImageRegistrationModeSupported(OniImageRegistrationMode) override { return TRUE; }

private:
    const Settings settings_;
    std::unique_ptr<DepthSequence> sequence_;
    Emitter emitter_;
    const std::atomic<bool> &frozen_;
    OniVideoMode mode_;
    OniSensorInfo sensor_;
};

class TestDriver final : public oni::driver::DriverBase {
public:
    explicit TestDriver(OniDriverServices *services)
        : DriverBase(services), settings_(settings_from_environment()) {}

    OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                         oni::driver::DeviceDisconnectedCallback disconnected,
                         oni::driver::DeviceStateChangedCallback changed, void *cookie) override {
        DriverBase::initialize(connected, disconnected, changed, cookie);
        std::snprintf(info_.uri, sizeof info_.uri, "%s", uri);
        std::snprintf(info_.vendor, sizeof info_.vendor, "afterglow");
        std::snprintf(info_.name, sizeof info_.name, "test camera");
        plug(settings_.plugged);
        if (!settings_.commands.empty())
            listener_ = std::thread([this] { listen(); });
        return ONI_STATUS_OK;
    }
    OniStatus tryDevice(const char *wanted) override {
        return plugged_ && std::strcmp(wanted, uri) == 0 ? ONI_STATUS_OK : ONI_STATUS_ERROR;
    }
    oni::driver::DeviceBase *deviceOpen(const char *wanted, const char * /*mode*/) override {
        if (tryDevice(wanted) != ONI_STATUS_OK)
            return nullptr;
        Result<std::unique_ptr<DepthSequence>> sequence = open_depth_sequence(settings_);
        if (!sequence) {
            getServices().errorLoggerAppend("%s", sequence.error().message.c_str());
            return nullptr;
        }
        return new TestDevice(settings_, *std::move(sequence), frozen_);
    }
    void deviceClose(oni::driver::DeviceBase *device) override { delete device; }
    void shutdown() override {
        stop_ = true;
        if (listener_.joinable())
            listener_.join();
    }

private:
    /// "unplug", "plug", "freeze", "go": a line each.
    void obey(const std::string &command) {
        if (command == "freeze" || command == "go")
            frozen_ = command == "freeze";
        else if (command == "plug" || command == "unplug")
            plug(command == "plug");
    }

    void plug(bool in) {
        if (plugged_.exchange(in) == in)
            return;
        if (in)
            deviceConnected(&info_);
        else
            deviceDisconnected(&info_);
    }

    void listen() {
        // Opened for writing too, so that it is not at its end when a writer leaves.
        const UniqueFd fifo(::open(settings_.commands.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
        std::string text;
        while (fifo && !stop_) {
            pollfd waiting = {fifo.get(), POLLIN, 0};
            std::array<char, 256> bytes{};
            if (::poll(&waiting, 1, 50) <= 0)
                continue;
            const ssize_t got = ::read(fifo.get(), bytes.data(), bytes.size());
            text.append(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
            for (std::size_t end; (end = text.find('\n')) != std::string::npos;) {
                obey(text.substr(0, end));
                text.erase(0, end + 1);
            }
        }
    }

    const Settings settings_;
    OniDeviceInfo info_ = {};
    std::atomic<bool> plugged_ = false;
    std::atomic<bool> frozen_ = false;
    std::atomic<bool> stop_ = false;
    std::thread listener_;
};

} // namespace
} // namespace afterglow::testcam

using afterglow::testcam::TestDriver;
ONI_EXPORT_DRIVER(TestDriver)
