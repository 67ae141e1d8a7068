// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/formats.hpp"

#include "drivers/v4l2/exotic_luma.hpp"
#include "drivers/v4l2/luma_reader.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace afterglow::libcam {
namespace {

struct Pair {
    std::uint32_t v4l2;
    std::uint32_t drm;
};
// drm_fourcc.h: DRM_FORMAT_R8, DRM_FORMAT_R16.
constexpr std::array differing = {Pair{V4L2_PIX_FMT_GREY, v4l2_fourcc('R', '8', ' ', ' ')},
                                  Pair{V4L2_PIX_FMT_Y16, v4l2_fourcc('R', '1', '6', ' ')}};

} // namespace

std::vector<std::uint32_t> readable_formats() {
    const auto exotic = v4l2::exotic_luma_formats();
    std::vector<std::uint32_t> formats;
    for (const std::uint32_t code : v4l2::luma_formats()) {
        if (std::find(exotic.begin(), exotic.end(), code) == exotic.end())
            formats.push_back(code);
    }
    return formats;
}

std::uint32_t drm_code(std::uint32_t v4l2_code) {
    for (const Pair &pair : differing) {
        if (pair.v4l2 == v4l2_code)
            return pair.drm;
    }
    return v4l2_code;
}

std::uint32_t v4l2_code(std::uint32_t drm_code) {
    for (const Pair &pair : differing) {
        if (pair.drm == drm_code)
            return pair.v4l2;
    }
    return drm_code;
}

} // namespace afterglow::libcam
