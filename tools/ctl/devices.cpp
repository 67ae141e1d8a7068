// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/devices.hpp"

#include "core/base/printable.hpp"
#include "tools/ctl/command.hpp"
#include "tools/ctl/json.hpp"

#include <fmt/format.h>

namespace afterglow {
namespace {

template <class Found>
void print_cameras(const char *title, const std::vector<Found> &cameras) {
    fmt::print("{}\n", title);
    for (const Found &camera : cameras)
        fmt::print("  {}\n    driver = \"{}\"\n    device = \"{}\"\n    gives {}\n",
                   printable(camera.title), camera.driver, printable(camera.device),
                   camera.modes.empty() ? "what it does not say" : camera.modes);
    if (cameras.empty())
        fmt::print("  none\n");
}

template <class Found>
Json to_json(const std::vector<Found> &cameras) {
    Json array = Json::array();
    for (const Found &camera : cameras)
        array.push_back({{"driver", camera.driver},
                         {"device", camera.device},
                         {"title", camera.title},
                         {"modes", camera.modes}});
    return array;
}

Json to_json(const std::vector<FoundLight> &lights) {
    Json array = Json::array();
    for (const FoundLight &light : lights)
        array.push_back(
            {{"driver", light.driver}, {"device", light.device}, {"title", light.title}});
    return array;
}

void print_lights(const std::vector<FoundLight> &lights) {
    fmt::print("Lights\n");
    for (const FoundLight &light : lights)
        fmt::print("  {}\n    driver = \"{}\"\n{}", printable(light.title), light.driver,
                   light.device.empty()
                       ? ""
                       : fmt::format("    device = \"{}\"\n", printable(light.device)));
    if (lights.empty())
        fmt::print("  none\n");
}

Result<int> show(const Settings &settings) {
    const FoundDevices devices = find_devices();
    if (settings.json)
        return print_json({{"color_cameras", to_json(devices.color)},
                           {"tof_cameras", to_json(devices.tof)},
                           {"lights", to_json(devices.lights)},
                           {"problems", devices.problems}});
    print_cameras("Colour cameras", devices.color);
    print_cameras("TOF cameras", devices.tof);
    print_lights(devices.lights);
    for (const std::string &problem : devices.problems)
        fmt::print(stderr, "afterglowctl: {}\n", problem);
    return 0;
}

} // namespace

Action declare_devices(CLI::App & /*app*/, const Settings &settings) {
    return [&settings] { return show(settings); };
}

} // namespace afterglow
