// SPDX-License-Identifier: Apache-2.0
#include "daemon/open_rig.hpp"

#include "daemon/light_switch.hpp"
#include "drivers/illuminator/illuminators.hpp"
#ifdef AFTERGLOW_WITH_V4L2
#include "drivers/v4l2/v4l2.hpp"
#endif
#ifdef AFTERGLOW_WITH_LIBCAMERA
#include "drivers/libcamera/libcamera.hpp"
#endif
#ifdef AFTERGLOW_WITH_OPENNI2
#include "drivers/openni2/openni2.hpp"
#endif

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace afterglow {
namespace {

using Light = std::unique_ptr<Illuminator>;

std::chrono::nanoseconds milliseconds(double ms) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double, std::milli>(ms));
}

[[maybe_unused]] Error left_out(const char *library) {
    return {fmt::format("this afterglowd was built without {}", library), ENOSYS};
}

/// The colour source of a rig, of which nobody needs the rest.
Result<std::unique_ptr<ColorSource>> color_of(Result<Rig> rig) {
    if (!rig)
        return rig.error();
    return std::move(rig->color);
}

Result<std::unique_ptr<ColorSource>> open_color(const Config &config) {
    const Config::Color &color = config.color;
    switch (color.driver) {
    case ColorDriver::synthetic:
        return color_of(open_synthetic(config.synthetic));
    case ColorDriver::replay:
        return color_of(open_replay(config.replay));
    case ColorDriver::v4l2:
#ifdef AFTERGLOW_WITH_V4L2
        return open_v4l2_color({color.device, color.camera, color.fps, color.format});
#else
        return left_out("V4L2");
#endif
    case ColorDriver::libcamera:
#ifdef AFTERGLOW_WITH_LIBCAMERA
        return open_libcamera_color({color.device, color.camera, color.fps, color.format});
#else
        return left_out("libcamera");
#endif
    }
    return Error{"there is no such driver", 0};
}

/// A TOF camera, and the light that is one with it where the configuration says so.
struct Tof {
    std::unique_ptr<TofSource> source;
    Light light;
};

#ifdef AFTERGLOW_WITH_OPENNI2
std::shared_ptr<OpenNi2Device> openni2_device(const Config &config, const Intrinsics &camera) {
    return std::make_shared<OpenNi2Device>(
        OpenNi2Options{config.tof.device, camera, config.tof.fps, config.tof.registration,
                       config.illuminator.driver == LightDriver::openni2_stream});
}

/// The device's own light, if the configuration names one.
Light openni2_light(const Config &config, const std::shared_ptr<OpenNi2Device> &device) {
    if (config.illuminator.driver == LightDriver::openni2_stream)
        return open_openni2_stream_light(device);
    if (config.illuminator.driver != LightDriver::openni2_emitter)
        return nullptr;
    const auto size = config.illuminator.payload == EmitterPayload::u8    ? 1
                      : config.illuminator.payload == EmitterPayload::i32 ? 4
                                                                          : 8;
    return open_openni2_emitter(device, config.illuminator.property, size);
}
#endif

Result<Tof> open_tof(const Config &config, [[maybe_unused]] const Intrinsics &camera) {
    if (config.tof.driver == TofDriver::openni2) {
#ifdef AFTERGLOW_WITH_OPENNI2
        const auto device = openni2_device(config, camera);
        return Tof{open_openni2_tof(device), openni2_light(config, device)};
#else
        return left_out("OpenNI2");
#endif
    }
#ifdef AFTERGLOW_WITH_V4L2
    const Config::Tof &tof = config.tof;
    auto source =
        open_v4l2_tof({tof.device, camera, tof.fps, tof.format, tof.mm_per_unit, tof.invalid,
                       tof.packing, tof.amplitude_device, tof.amplitude_format});
    if (!source)
        return source.error();
    return Tof{*std::move(source), nullptr};
#else
    return left_out("V4L2");
#endif
}

/// A light that is no part of the TOF camera.
Result<Light> open_light(const Config::Light &light) {
    switch (light.driver) {
    case LightDriver::v4l2_control:
#ifdef AFTERGLOW_WITH_V4L2
        return open_v4l2_control(
            {light.device, light.control, light.on, light.off, light.off_control});
#else
        return left_out("V4L2");
#endif
    case LightDriver::led:
        return open_led({light.device, light.on, light.off});
    case LightDriver::gpio:
        return open_gpio({light.device, light.line, light.active_low});
    default:
        return open_no_light();
    }
}

/// A rig that is one simulated device.
Result<Rig> open_simulated(const Config &config) {
    return config.color.driver == ColorDriver::synthetic ? open_synthetic(config.synthetic)
                                                         : open_replay(config.replay);
}

bool is_simulated(const Config &config) {
    return config.tof.driver == TofDriver::synthetic || config.tof.driver == TofDriver::replay;
}

} // namespace

Result<Rig> open_rig(const Config &config) {
    if (is_simulated(config))
        return open_simulated(config);
    Result<std::unique_ptr<ColorSource>> color = open_color(config);
    if (!color)
        return color.error();
    // Registered depth has the size of the images.
    Result<Tof> tof = open_tof(config, config.calibration.rig ? config.calibration.rig->tof.pinhole
                                                              : (*color)->intrinsics());
    if (!tof)
        return tof.error();
    if (!tof->light) {
        Result<Light> light = open_light(config.illuminator);
        if (!light)
            return light.error();
        tof->light = *std::move(light);
    }
    // What cannot be switched needs no thread for it.
    if (config.illuminator.driver != LightDriver::none)
        tof->light = std::make_unique<LightSwitch>(std::move(tof->light));
    Pairing pairing = {milliseconds(config.tof.pairing_tolerance_ms),
                       milliseconds(config.tof.pairing_wait_ms), milliseconds(config.tof.delay_ms),
                       config.tof.warmup_maps, config.tof.least_amplitude};
    // The images of a slow camera are far apart.
    pairing.furthest_ahead =
        std::max(pairing.furthest_ahead, milliseconds(2000 / config.color.fps));
    return Rig{*std::move(color), std::move(tof->source), std::move(tof->light), pairing};
}

Status darken(const Config &config) {
    if (is_simulated(config))
        return ok();
    const bool is_openni2 = config.illuminator.driver == LightDriver::openni2_emitter ||
                            config.illuminator.driver == LightDriver::openni2_stream;
    if (is_openni2) {
#ifdef AFTERGLOW_WITH_OPENNI2
        const auto device = openni2_device(config, config.color.camera);
        const Light light = openni2_light(config, device); // names the emitter
        return device->darken();
#else
        return left_out("OpenNI2");
#endif
    }
    const Result<Light> light = open_light(config.illuminator);
    return light ? (*light)->set(false) : Status(light.error());
}

} // namespace afterglow
