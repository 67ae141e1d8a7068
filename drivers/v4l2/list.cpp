// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/list.hpp"

#include "core/base/unique_fd.hpp"
#include "drivers/v4l2/depth_formats.hpp"
#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/luma_reader.hpp"
#include "drivers/v4l2/negotiate.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>

namespace afterglow {
namespace {

using namespace v4l2;

/// The sizes of a format; of a range of sizes its largest.
std::vector<std::pair<int, int>> sizes_of(SystemCalls &calls, int fd, std::uint32_t fourcc) {
    std::vector<std::pair<int, int>> sizes;
    v4l2_frmsizeenum size = {};
    size.pixel_format = fourcc;
    for (; calls.ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
        const bool is_one = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
        sizes.emplace_back(is_one ? size.discrete.width : size.stepwise.max_width,
                           is_one ? size.discrete.height : size.stepwise.max_height);
        if (!is_one)
            break;
    }
    return sizes;
}

std::vector<V4l2Mode> modes_of(SystemCalls &calls, int fd, const std::string &path) {
    std::vector<V4l2Mode> modes;
    const Result<std::uint32_t> type = capture_type(calls, fd, path);
    if (!type)
        return modes;
    for (const std::uint32_t fourcc : formats_of(calls, fd, *type)) {
        const bool is_luma = contains(luma_formats(), fourcc);
        // What may be either is most often not depth; Z16 and its like are nothing else.
        const bool is_depth = !is_luma && contains(depth_formats(), fourcc);
        if (!is_luma && !is_depth)
            continue;
        for (const auto &[width, height] : sizes_of(calls, fd, fourcc)) {
            constexpr double any_rate = 1000;
            const double fps = best_rate(calls, fd, fourcc, {path, width, height, any_rate, {}});
            modes.push_back({to_string(fourcc), width, height, fps < any_rate ? fps : 0, is_depth});
        }
    }
    return modes;
}

bool is_about_light(std::string_view control) {
    static constexpr std::array<std::string_view, 8> words = {
        "led", "flash", "strobe", "laser", "emitter", "illumin", "torch", "ir_"};
    return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
        const std::size_t at = control.find(word);
        return at != std::string_view::npos && (at == 0 || control[at - 1] == '_');
    });
}

std::vector<V4l2LightControl> lights_of(SystemCalls &calls, int fd) {
    std::vector<V4l2LightControl> lights;
    v4l2_query_ext_ctrl control = {};
    control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
    for (; calls.ioctl(fd, VIDIOC_QUERY_EXT_CTRL, &control) == 0;
         control.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
        const std::string name = plain_name(control.name);
        const std::uint32_t useless =
            V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_INACTIVE;
        if (control.type != V4L2_CTRL_TYPE_CTRL_CLASS && (control.flags & useless) == 0 &&
            is_about_light(name))
            lights.push_back({name, control.minimum, control.maximum});
    }
    return lights;
}

/// The name of a link to `path` in one of udev's folders; empty if there is none.
std::string link_to(const std::string &path) {
    std::error_code error;
    for (const char *folder : {"/dev/v4l/by-id", "/dev/v4l/by-path"})
        for (const auto &link : std::filesystem::directory_iterator(folder, error))
            if (std::filesystem::canonical(link.path(), error) == path)
                return link.path().filename();
    return {};
}

} // namespace

std::vector<V4l2Listing> list_v4l2_devices(SystemCalls &calls) {
    std::vector<V4l2Listing> listings;
    for (const std::string &path : calls.video_nodes()) {
        const UniqueFd fd(calls.open(path));
        v4l2_capability about = {};
        if (!fd)
            continue;
        V4l2Listing listing;
        listing.path = path;
        listing.stable_name = link_to(path);
        if (calls.ioctl(fd.get(), VIDIOC_QUERYCAP, &about) == 0) {
            listing.card = kernel_text(about.card);
            if (listing.stable_name.empty())
                listing.stable_name = kernel_text(about.bus_info);
        }
        listing.modes = modes_of(calls, fd.get(), path);
        listing.lights = lights_of(calls, fd.get());
        if (!listing.modes.empty() || !listing.lights.empty())
            listings.push_back(std::move(listing));
    }
    return listings;
}

} // namespace afterglow
