// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/devices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>

namespace afterglow {
namespace {

/// The light that belongs to the TOF camera, if one does: a LED or a GPIO line that happens to be
/// there is not switched on a guess.
const FoundLight *light_of(const FoundDevices &devices, const FoundTof &tof) {
    const std::string driver = tof.driver == "openni2" ? "openni2-emitter" : "v4l2-control";
    const auto light = std::find_if(
        devices.lights.begin(), devices.lights.end(), [&](const FoundLight &candidate) {
            return candidate.driver == driver &&
                   (candidate.device.empty() || candidate.device == tof.device);
        });
    return light == devices.lights.end() ? nullptr : &*light;
}

/// A TOML string.
std::string quoted(const std::string &text) {
    std::string quoted = "\"";
    for (const char letter : text) {
        if (letter == '"' || letter == '\\')
            quoted += '\\';
        if (static_cast<unsigned char>(letter) >= ' ')
            quoted += letter;
    }
    return quoted + '"';
}

} // namespace

Result<std::string> first_configuration(const FoundDevices &devices) {
    if (devices.color.empty())
        return Error{"there is no colour camera", ENODEV};
    if (devices.tof.empty())
        return Error{"there is no TOF camera", ENODEV};
    const FoundColor &color = devices.color.front();
    const FoundTof &tof = devices.tof.front();
    const FoundLight *light = light_of(devices, tof);
    // Of 60 degrees of view, as many have; 525 of 640 pixels are a Kinect's.
    const double focal_length = 525.0 * color.width / 640;
    std::string text =
        fmt::format("# Written by afterglowctl probe. Calibrate fx, fy, cx and cy: "
                    "here they are guessed.\n"
                    "# {}\n[color]\ndriver = {}\ndevice = {}\nwidth = {}\n"
                    "height = {}\nfps = {:.1f}\nfx = {:.1f}\nfy = {:.1f}\n"
                    "cx = {:.1f}\ncy = {:.1f}\n\n",
                    printable(color.title), quoted(color.driver), quoted(color.device), color.width,
                    color.height, color.fps, focal_length, focal_length, (color.width - 1) / 2.0,
                    (color.height - 1) / 2.0);
    text += fmt::format("# {}\n[tof]\ndriver = {}\ndevice = {}\n", printable(tof.title),
                        quoted(tof.driver), quoted(tof.device));
    if (tof.driver == "openni2")
        text += fmt::format("registration = {}\n", tof.registration);
    if (light)
        text += fmt::format("\n# {}\n[illuminator]\ndriver = {}\n{}{}", printable(light->title),
                            quoted(light->driver),
                            light->device.empty() ? "" : "device = " + quoted(light->device) + "\n",
                            light->keys);
    else
        text += "\n# No light was found that belongs to the TOF camera.\n"
                "[illuminator]\ndriver = \"none\"\n";
    return text;
}

} // namespace afterglow
