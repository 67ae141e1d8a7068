// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/commands.hpp"
#include "tools/ctl/devices.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

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

} // namespace

Status show_devices() {
    const FoundDevices devices = find_devices();
    print_cameras("Colour cameras", devices.color);
    print_cameras("TOF cameras", devices.tof);
    fmt::print("Lights\n");
    for (const FoundLight &light : devices.lights)
        fmt::print("  {}\n    driver = \"{}\"\n{}", printable(light.title), light.driver,
                   light.device.empty()
                       ? ""
                       : fmt::format("    device = \"{}\"\n", printable(light.device)));
    if (devices.lights.empty())
        fmt::print("  none\n");
    for (const std::string &problem : devices.problems)
        fmt::print(stderr, "afterglowctl: {}\n", problem);
    return ok();
}

Status probe(const std::string &path) {
    const Result<std::string> configuration = first_configuration(find_devices());
    if (!configuration)
        return configuration.error();
    if (path.empty()) {
        fmt::print("{}", *configuration);
        return ok();
    }
    // Never over a configuration that somebody has written.
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    std::FILE *file = fd < 0 ? nullptr : ::fdopen(fd, "w");
    const bool written = file && std::fputs(configuration->c_str(), file) >= 0;
    const bool closed = file && std::fclose(file) == 0;
    if (!written || !closed)
        return Error{fmt::format("{} cannot be written: {}", printable(path), std::strerror(errno)),
                     errno};
    fmt::print("{}\n", path);
    return ok();
}

} // namespace afterglow
