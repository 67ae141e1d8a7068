// SPDX-License-Identifier: Apache-2.0
#include "drivers/openni2/depth_mode.hpp"
#include "drivers/openni2/library.hpp"
#include "drivers/openni2/openni2.hpp"

#include <fmt/format.h>

namespace afterglow {

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
        if (const openni::SensorInfo *depth = device.getSensorInfo(openni::SENSOR_DEPTH)) {
            const auto &modes = depth->getSupportedVideoModes();
            for (int mode = 0; mode < modes.getSize(); ++mode)
                if (openni2::is_depth(modes[mode]))
                    listing.depth_modes.push_back(openni2::describe(modes[mode]));
        }
        device.close();
    }
    return listings;
}

} // namespace afterglow
