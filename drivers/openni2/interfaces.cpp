// SPDX-License-Identifier: Apache-2.0
#include "drivers/illuminator/illuminators.hpp"
#include "drivers/openni2/openni2.hpp"

#include <utility>

namespace afterglow {
namespace {

class OpenNi2Tof final : public TofSource {
public:
    explicit OpenNi2Tof(std::shared_ptr<OpenNi2Device> device) : device_(std::move(device)) {}
    const Intrinsics &intrinsics() const override { return device_->intrinsics(); }
    Status start() override { return device_->start(); }
    void stop() override { device_->stop(); }
    Capture read(DepthFrame &frame, std::chrono::nanoseconds timeout) override {
        return device_->read(frame, timeout);
    }
    const std::string &problem() const override { return device_->problem(); }

private:
    std::shared_ptr<OpenNi2Device> device_;
};

/// A light that `Switch` switches: a call with the device and the state.
template <class Switch>
class OpenNi2Light final : public Illuminator {
public:
    OpenNi2Light(std::shared_ptr<OpenNi2Device> device, Switch switch_light)
        : device_(std::move(device)), switch_light_(switch_light) {
        static_cast<void>(set(false));
    }
    ~OpenNi2Light() override { leave_dark(*this); }
    Status set(bool lit) override {
        Status done = switch_light_(*device_, lit);
        if (done)
            lit_ = lit;
        return done;
    }
    bool lit() const override { return lit_; }

private:
    std::shared_ptr<OpenNi2Device> device_;
    Switch switch_light_;
    bool lit_ = false;
};

template <class Switch>
std::unique_ptr<Illuminator> make_light(std::shared_ptr<OpenNi2Device> device,
                                        Switch switch_light) {
    return std::make_unique<OpenNi2Light<Switch>>(std::move(device), switch_light);
}

} // namespace

std::unique_ptr<TofSource> open_openni2_tof(std::shared_ptr<OpenNi2Device> device) {
    return std::make_unique<OpenNi2Tof>(std::move(device));
}

std::unique_ptr<Illuminator> open_openni2_emitter(std::shared_ptr<OpenNi2Device> device,
                                                  int property, int size) {
    return make_light(std::move(device), [property, size](OpenNi2Device &it, bool lit) {
        return it.set_emitter(property, size, lit);
    });
}

std::unique_ptr<Illuminator> open_openni2_stream_light(std::shared_ptr<OpenNi2Device> device) {
    return make_light(std::move(device),
                      [](OpenNi2Device &it, bool lit) { return it.set_streaming(lit); });
}

} // namespace afterglow
