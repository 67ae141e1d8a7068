// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/devices.hpp"

#ifdef AFTERGLOW_WITH_LIBCAMERA
#include "drivers/libcamera/libcamera.hpp"
#endif
#ifdef AFTERGLOW_WITH_OPENNI2
#include "drivers/openni2/openni2.hpp"
#endif
#ifdef AFTERGLOW_WITH_V4L2
#include "drivers/v4l2/list.hpp"
#endif

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace afterglow {
namespace {

#ifdef AFTERGLOW_WITH_V4L2
std::string describe(const std::vector<V4l2Mode> &modes, bool depth) {
    std::string text;
    for (const V4l2Mode &mode : modes) {
        if (mode.is_depth != depth)
            continue;
        text += fmt::format("{}{} {}x{}", text.empty() ? "" : ", ", mode.format, mode.width,
                            mode.height);
        if (mode.fps > 0)
            text += fmt::format(" at {:g}", mode.fps);
    }
    return text;
}

/// The mode nearest to 640x480 at 30.
const V4l2Mode &usual_mode(const std::vector<V4l2Mode> &modes) {
    const auto oddness = [](const V4l2Mode &mode) {
        return std::abs(mode.width - 640) + std::abs(mode.height - 480) +
               (mode.fps > 0 && mode.fps < 25 ? 1000 : 0) + (mode.is_depth ? 100'000 : 0);
    };
    return *std::min_element(modes.begin(), modes.end(), [&](const V4l2Mode &a, const V4l2Mode &b) {
        return oddness(a) < oddness(b);
    });
}

void add_v4l2(FoundDevices &found) {
    for (const V4l2Listing &node : list_v4l2_devices()) {
        const std::string title = fmt::format("{} ({})", node.card, node.path);
        const std::string colors = describe(node.modes, false);
        const std::string depths = describe(node.modes, true);
        if (!colors.empty()) {
            const V4l2Mode &mode = usual_mode(node.modes);
            found.color.push_back({"v4l2", node.stable_name, title, colors, mode.width, mode.height,
                                   mode.fps > 0 ? std::min(mode.fps, 30.0) : 30.0});
        }
        if (!depths.empty())
            found.tof.push_back({"v4l2", node.stable_name, title, depths, true});
        for (const V4l2LightControl &light : node.lights)
            found.lights.push_back({"v4l2-control", node.stable_name,
                                    fmt::format("{}: {} from {} to {}", title, light.name,
                                                light.minimum, light.maximum),
                                    fmt::format("control = \"{}\"\non = {}\noff = {}\n", light.name,
                                                light.maximum, light.minimum)});
    }
}
#endif

#ifdef AFTERGLOW_WITH_LIBCAMERA
void add_libcamera(FoundDevices &found) {
    const auto listings = list_libcamera_cameras();
    if (!listings) {
        found.problems.push_back(listings.error().message);
        return;
    }
    for (const LibcameraListing &camera : *listings) {
        FoundColor &color = found.color.emplace_back(FoundColor{
            "libcamera", camera.id, camera.model + " (libcamera)", describe(camera.modes, false)});
        if (camera.modes.empty())
            continue;
        const V4l2Mode &mode = usual_mode(camera.modes);
        color.width = mode.width;
        color.height = mode.height;
    }
}
#endif

#ifdef AFTERGLOW_WITH_OPENNI2
void add_openni2(FoundDevices &found) {
    const auto listings = list_openni2_devices();
    if (!listings) {
        found.problems.push_back(listings.error().message);
        return;
    }
    for (const OpenNi2Listing &device : *listings) {
        found.tof.push_back({"openni2", device.uri, device.name,
                             fmt::format("{}", fmt::join(device.depth_modes, ", ")),
                             device.can_register});
        const bool is_link = device.name.find("PSLink") != std::string::npos;
        found.lights.push_back({"openni2-emitter", "", device.name + ": its emitter",
                                is_link ? "property = 0x12000008\npayload = \"int32\"\n"
                                        : "property = 0x1080E007\npayload = \"uint64\"\n"});
        found.lights.push_back({"openni2-stream", "", device.name + ": its stream", ""});
    }
}
#endif

void add_leds(FoundDevices &found) {
    std::error_code none;
    for (const auto &led : std::filesystem::directory_iterator("/sys/class/leds", none)) {
        int most = 1;
        std::ifstream(led.path() / "max_brightness") >> most;
        const std::string name = led.path().filename();
        found.lights.push_back({"led", name, fmt::format("LED {}, up to {}", name, most),
                                fmt::format("on = {}\n", most)});
    }
}

void add_gpio_chips(FoundDevices &found) {
    std::error_code none;
    for (const auto &entry : std::filesystem::directory_iterator("/dev", none)) {
        const std::string name = entry.path().filename();
        if (name.starts_with("gpiochip"))
            found.lights.push_back({"gpio", name, "GPIO chip " + name, "line = 0\n"});
    }
}

} // namespace

FoundDevices find_devices() {
    FoundDevices found;
#ifdef AFTERGLOW_WITH_OPENNI2
    add_openni2(found);
#endif
#ifdef AFTERGLOW_WITH_V4L2
    add_v4l2(found);
#endif
#ifdef AFTERGLOW_WITH_LIBCAMERA
    add_libcamera(found);
#endif
    add_leds(found);
    add_gpio_chips(found);
    return found;
}

} // namespace afterglow
