// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/exotic_luma.hpp"
#include "drivers/v4l2/luma_reader.hpp"
#include "drivers/v4l2/mjpeg_luma.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <vector>

namespace afterglow::v4l2 {
namespace {

/// Where a format that is not compressed keeps its luma: a byte every `step`, from `offset`.
struct LumaBytes {
    std::uint32_t fourcc;
    int step;
    int offset;
};

constexpr std::array byte_formats = {
    LumaBytes{V4L2_PIX_FMT_GREY, 1, 0},
    LumaBytes{V4L2_PIX_FMT_Y16, 2, 1}, // the upper byte of a little-endian number
    LumaBytes{V4L2_PIX_FMT_NV12, 1, 0},
    LumaBytes{V4L2_PIX_FMT_NV21, 1, 0},
    LumaBytes{V4L2_PIX_FMT_NV12M, 1, 0},
    LumaBytes{V4L2_PIX_FMT_NV16, 1, 0},
    LumaBytes{V4L2_PIX_FMT_YUV420, 1, 0},
    LumaBytes{V4L2_PIX_FMT_YVU420, 1, 0},
    LumaBytes{V4L2_PIX_FMT_YUYV, 2, 0},
    LumaBytes{V4L2_PIX_FMT_YVYU, 2, 0},
    LumaBytes{V4L2_PIX_FMT_UYVY, 2, 1},
    LumaBytes{V4L2_PIX_FMT_VYUY, 2, 1},
};
constexpr std::array jpeg_formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG};

/// The step is a constant so that the compiler can make vector code of the loop.
template <int step>
void read_row(const std::uint8_t *from, std::uint8_t *to, int width) {
    for (int u = 0; u < width; ++u)
        to[u] = from[step * u];
}

template <int step>
LumaReader read_every(const FrameLayout &layout, int offset) {
    return [layout, offset](std::span<const std::uint8_t> bytes, ImageView<std::uint8_t> luma) {
        if (is_short(layout, std::size_t{step} * static_cast<std::size_t>(layout.width),
                     bytes.size()))
            return too_short;
        for (int v = 0; v < layout.height; ++v)
            read_row<step>(bytes.data() + static_cast<std::size_t>(v) * layout.stride + offset,
                           luma.row(v), layout.width);
        return std::string_view();
    };
}

} // namespace

std::span<const std::uint32_t> luma_formats() {
    static const std::vector<std::uint32_t> formats = [] {
        std::vector<std::uint32_t> codes;
        for (const LumaBytes &format : byte_formats)
            codes.push_back(format.fourcc);
        codes.insert(codes.end(), jpeg_formats.begin(), jpeg_formats.end());
        const auto exotic = exotic_luma_formats();
        codes.insert(codes.end(), exotic.begin(), exotic.end());
        return codes;
    }();
    return formats;
}

LumaReader make_luma_reader(const FrameLayout &layout, int fd) {
    for (const LumaBytes &format : byte_formats) {
        if (format.fourcc == layout.fourcc)
            return format.step == 1 ? read_every<1>(layout, format.offset)
                                    : read_every<2>(layout, format.offset);
    }
    if (contains(jpeg_formats, layout.fourcc))
        return make_mjpeg_reader();
    return make_exotic_reader(layout, fd);
}

bool is_short(const FrameLayout &layout, std::size_t row_bytes, std::size_t bytes) {
    const auto rows_before_last = static_cast<std::size_t>(layout.height - 1);
    return layout.stride < row_bytes || bytes < rows_before_last * layout.stride + row_bytes;
}

} // namespace afterglow::v4l2
