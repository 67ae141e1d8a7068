// SPDX-License-Identifier: Apache-2.0
#include "drivers/openni2/depth_mode.hpp"
#include "drivers/openni2/library.hpp"
#include "drivers/openni2/openni2.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

/// Nothing where the device has none, or an impossible one.
std::optional<FieldOfView> field_of(openni::Device &device) {
    openni::VideoStream depth;
    if (depth.create(device, openni::SENSOR_DEPTH) != openni::STATUS_OK)
        return std::nullopt;
    const FieldOfView field = {depth.getHorizontalFieldOfView(), depth.getVerticalFieldOfView()};
    depth.destroy();
    const auto is_possible = [](double angle) { return angle > 0 && angle < std::numbers::pi; };
    if (!is_possible(field.horizontal) || !is_possible(field.vertical))
        return std::nullopt;
    return field;
}

std::string describe(const openni::VideoMode &mode, const std::optional<FieldOfView> &field) {
    if (!field)
        return openni2::describe(mode);
    const Intrinsics camera = pinhole_of(*field, mode.getResolutionX(), mode.getResolutionY());
    return fmt::format("{} (fx {:.1f}, fy {:.1f})", openni2::describe(mode), camera.fx, camera.fy);
}

} // namespace

Intrinsics pinhole_of(const FieldOfView &field, int width, int height) {
    return {width / 2.0 / std::tan(field.horizontal / 2),
            height / 2.0 / std::tan(field.vertical / 2),
            (width - 1) / 2.0,
            (height - 1) / 2.0,
            width,
            height};
}

Result<std::vector<OpenNi2Listing>> list_openni2_devices() {
    if (const Status loaded = openni2::load_library(); !loaded)
        return loaded.error();
    openni::Array<openni::DeviceInfo> infos;
    openni::OpenNI::enumerateDevices(&infos);
    std::vector<OpenNi2Listing> listings;
    for (int i = 0; i < infos.getSize(); ++i) {
        OpenNi2Listing &listing = listings.emplace_back();
        listing.uri = infos[i].getUri();
        listing.name = fmt::format("{} {}", infos[i].getVendor(), infos[i].getName());
        openni::Device device;
        if (device.open(infos[i].getUri()) != openni::STATUS_OK)
            continue; // in use: its modes are not to be had
        listing.can_register =
            device.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR);
        listing.field = field_of(device);
        if (const openni::SensorInfo *depth = device.getSensorInfo(openni::SENSOR_DEPTH)) {
            const auto &modes = depth->getSupportedVideoModes();
            for (int mode = 0; mode < modes.getSize(); ++mode)
                if (openni2::is_depth(modes[mode]))
                    listing.depth_modes.push_back(describe(modes[mode], listing.field));
        }
        device.close();
    }
    return listings;
}

} // namespace afterglow
