// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/exotic_luma.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cstring>
#include <libv4lconvert.h>
#include <memory>
#include <vector>

namespace afterglow::v4l2 {
namespace {

constexpr std::array formats = {
    V4L2_PIX_FMT_SBGGR8,  V4L2_PIX_FMT_SGBRG8,   V4L2_PIX_FMT_SGRBG8,  V4L2_PIX_FMT_SRGGB8,
    V4L2_PIX_FMT_BGR24,   V4L2_PIX_FMT_RGB24,    V4L2_PIX_FMT_RGB565,  V4L2_PIX_FMT_SPCA501,
    V4L2_PIX_FMT_SPCA505, V4L2_PIX_FMT_SPCA508,  V4L2_PIX_FMT_SPCA561, V4L2_PIX_FMT_SN9C10X,
    V4L2_PIX_FMT_PAC207,  V4L2_PIX_FMT_MR97310A, V4L2_PIX_FMT_OV511,   V4L2_PIX_FMT_OV518,
};

using Converter = std::unique_ptr<v4lconvert_data, decltype(&v4lconvert_destroy)>;

v4l2_format describe(const FrameLayout &layout, std::uint32_t fourcc, std::size_t stride,
                     std::size_t size) {
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = static_cast<std::uint32_t>(layout.width);
    format.fmt.pix.height = static_cast<std::uint32_t>(layout.height);
    format.fmt.pix.pixelformat = fourcc;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = static_cast<std::uint32_t>(stride);
    format.fmt.pix.sizeimage = static_cast<std::uint32_t>(size);
    return format;
}

/// Converts to planar YUV, whose first plane is luma.
class ExoticReader {
public:
    ExoticReader(const FrameLayout &layout, int fd)
        : converter_(v4lconvert_create(fd), &v4lconvert_destroy),
          yuv_(static_cast<std::size_t>(layout.width) * static_cast<std::size_t>(layout.height) *
               3 / 2),
          from_(describe(layout, layout.fourcc, layout.stride, layout.size)),
          to_(describe(layout, V4L2_PIX_FMT_YUV420, static_cast<std::size_t>(layout.width),
                       yuv_.size())) {
        source_.reserve(layout.size);
    }

    std::string_view read(std::span<const std::uint8_t> bytes, ImageView<std::uint8_t> luma) {
        // The library may balance Bayer pixels where they lie, and the driver's memory is mapped
        // for reading only.
        source_.assign(bytes.begin(), bytes.end());
        if (!converter_ || v4lconvert_convert(converter_.get(), &from_, &to_, source_.data(),
                                              static_cast<int>(source_.size()), yuv_.data(),
                                              static_cast<int>(yuv_.size())) < 0)
            return "libv4lconvert cannot read it";
        const auto width = static_cast<std::size_t>(luma.width());
        for (int v = 0; v < luma.height(); ++v)
            std::memcpy(luma.row(v), yuv_.data() + static_cast<std::size_t>(v) * width, width);
        return {};
    }

private:
    Converter converter_;
    std::vector<std::uint8_t> source_;
    std::vector<std::uint8_t> yuv_;
    v4l2_format from_;
    v4l2_format to_;
};

} // namespace

std::span<const std::uint32_t> exotic_luma_formats() {
    return formats;
}

LumaReader make_exotic_reader(const FrameLayout &layout, int fd) {
    // Shared because a std::function must be copyable; there is one owner.
    auto reader = std::make_shared<ExoticReader>(layout, fd);
    return [reader](std::span<const std::uint8_t> bytes, ImageView<std::uint8_t> luma) {
        return reader->read(bytes, luma);
    };
}

} // namespace afterglow::v4l2
