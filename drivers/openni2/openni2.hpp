// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/result.hpp"
#include "drivers/source.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace afterglow {

struct OpenNi2Options {
    std::string uri;   ///< of the device, or the path of a recording (.oni); "" = any device
    Intrinsics camera; ///< of the depth maps; with `registration` the colour camera's
    double fps = 30;   ///< asked of the device, which gives the nearest rate it has
    /// The device maps its depth onto its colour camera; one that cannot is refused. False: its
    /// depth is taken as it is.
    bool registration = true;
    bool stream_is_light = false; ///< the stream is started by set_streaming() alone
};

/// A TOF camera that has a driver for OpenNI2 and its light; open_...() below give its interfaces.
///
/// Nothing is opened before start(). start(), stop() and read() are called by the estimator thread,
/// set_emitter() and set_streaming() by that of a LightSwitch. They do not wait for each other,
/// except start() and stop() for a call of the other thread that is under way.
class OpenNi2Device {
public:
    explicit OpenNi2Device(OpenNi2Options options);
    ~OpenNi2Device();
    OpenNi2Device(const OpenNi2Device &) = delete;
    OpenNi2Device &operator=(const OpenNi2Device &) = delete;

    const Intrinsics &intrinsics() const;
    /// Errors: the library has no driver, there is no such device, it has no depth of that size,
    /// or is in use.
    Status start();
    void stop();
    /// DepthFrame::t_ns is the device's time, reconciled (DeviceClock).
    Capture read(DepthFrame &frame, std::chrono::nanoseconds timeout);
    const std::string &problem() const;

    /// Switches the emitter through a property of `size` bytes: 1, 4 or 8. A device that is not
    /// open counts as dark, and is switched off as soon as it is opened. Errors: ENODEV where it is
    /// to be lit and is not there or refuses.
    Status set_emitter(int property, int size, bool lit);
    Status set_streaming(bool running);
    /// Opens a device that is not open, switches its emitter off if set_emitter() has named one,
    /// and closes it, which ends a stream. Errors: ENODEV where it is absent, in use or refuses.
    Status darken();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

std::unique_ptr<TofSource> open_openni2_tof(std::shared_ptr<OpenNi2Device> device);
/// `property` and `size`: as for OpenNi2Device::set_emitter().
std::unique_ptr<Illuminator> open_openni2_emitter(std::shared_ptr<OpenNi2Device> device,
                                                  int property, int size);
/// For a device with OpenNi2Options::stream_is_light.
std::unique_ptr<Illuminator> open_openni2_stream_light(std::shared_ptr<OpenNi2Device> device);

/// What a device says that its depth maps show, radians.
struct FieldOfView {
    double horizontal = 0;
    double vertical = 0;
};
/// The pinhole camera with this field and its axis in the middle: a default, no calibration.
Intrinsics pinhole_of(const FieldOfView &field, int width, int height);

/// A device that OpenNI2 knows of.
struct OpenNi2Listing {
    std::string uri;
    std::string name; ///< vendor and model
    bool can_register = false;
    std::optional<FieldOfView> field;     ///< nothing: the device does not say
    std::vector<std::string> depth_modes; ///< "640x480 at 30, 1 mm (fx 575.8, fy 575.8)"; focal
                                          ///< lengths where there is a field
};
/// Those there are now. Errors: the library has no driver at all.
Result<std::vector<OpenNi2Listing>> list_openni2_devices();

} // namespace afterglow
