// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/device.hpp"

#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

namespace afterglow::v4l2 {
namespace {

constexpr std::uint32_t big_endian = 1U << 31;

bool is_called(SystemCalls &calls, int fd, std::string_view name) {
    v4l2_capability about = {};
    if (calls.ioctl(fd, VIDIOC_QUERYCAP, &about) != 0)
        return false;
    // A USB camera's metadata node has its bus and card too, but gives no images.
    const std::uint32_t captures = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE;
    return (capabilities(about) & captures) != 0 &&
           (kernel_text(about.bus_info) == name || kernel_text(about.card) == name);
}

} // namespace

std::uint32_t capabilities(const v4l2_capability &about) {
    return (about.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? about.device_caps
                                                            : about.capabilities;
}

std::string to_string(std::uint32_t fourcc) {
    std::string name;
    for (int shift = 0; shift < 32; shift += 8) {
        const auto letter = static_cast<char>((fourcc & ~big_endian) >> shift & 0xff);
        name += letter > ' ' && letter < 127 ? letter : ' ';
    }
    name.erase(name.find_last_not_of(' ') + 1);
    return (fourcc & big_endian) != 0 ? name + "-BE" : name;
}

bool contains(std::span<const std::uint32_t> codes, std::uint32_t fourcc) {
    return std::ranges::find(codes, fourcc) != codes.end();
}

std::uint32_t fourcc_from_string(std::string_view name) {
    std::uint32_t fourcc = 0;
    if (name.ends_with("-BE")) {
        name.remove_suffix(3);
        fourcc = big_endian;
    }
    if (name.empty() || name.size() > 4)
        return 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const char letter = i < name.size() ? name[i] : ' ';
        if (letter < ' ' || letter >= 127)
            return 0;
        fourcc |= static_cast<std::uint32_t>(letter) << 8 * i;
    }
    return fourcc;
}

std::string plain_name(std::string_view control) {
    std::string plain;
    for (const char letter : control) {
        if (std::isalnum(static_cast<unsigned char>(letter)) != 0)
            plain += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
        else if (!plain.empty() && plain.back() != '_')
            plain += '_';
    }
    if (plain.ends_with('_'))
        plain.pop_back();
    return plain;
}

Result<UniqueFd> open_device(SystemCalls &calls, const std::string &name) {
    if (name.starts_with('/')) {
        UniqueFd fd(calls.open(name));
        if (!fd)
            return device_error(name, "open it", errno);
        return fd;
    }
    for (const char *folder : {"/dev/v4l/by-id/", "/dev/v4l/by-path/"}) {
        if (UniqueFd fd(calls.open(folder + name)); fd)
            return fd;
        if (errno != ENOENT)
            return device_error(name, "open it", errno);
    }
    Error absent = device_error(name, "find it", ENOENT);
    for (const std::string &node : calls.video_nodes()) {
        UniqueFd fd(calls.open(node));
        if (fd && is_called(calls, fd.get(), name))
            return fd;
        if (!fd && errno != ENOENT)
            absent.message =
                fmt::format("no camera that can be opened is called '{}'; of the others: {}",
                            printable(name), device_error(node, "open it", errno).message);
    }
    return absent;
}

Error device_error(const std::string &device, std::string_view doing, int code) {
    const std::string name = printable(device);
    switch (code) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
        return {fmt::format("the camera '{}' is not there", name), code};
    case EBUSY:
        return {fmt::format("the camera '{}' is in use by another program", name), code};
    case EACCES:
    case EPERM:
        return {fmt::format("the camera '{}' may not be used by this user (group video)", name),
                code};
    case ENOTTY:
        return {fmt::format("'{}' is no V4L2 device that could {}", name, doing), code};
    default:
        return {fmt::format("the camera '{}' failed to {}: {}", name, doing, std::strerror(code)),
                code};
    }
}

} // namespace afterglow::v4l2
