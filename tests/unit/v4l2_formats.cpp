// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/luma_reader.hpp"
#include "tests/catch.hpp"

#include <jpeglib.h>
#include <linux/videodev2.h>

#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <vector>

using namespace afterglow;
using namespace afterglow::v4l2;

namespace {

using Bytes = std::vector<std::uint8_t>;

FrameLayout layout_of(std::uint32_t fourcc, int width, int height, std::size_t stride) {
    FrameLayout layout;
    layout.fourcc = fourcc;
    layout.width = width;
    layout.height = height;
    layout.stride = stride;
    layout.size = stride * static_cast<std::size_t>(height);
    return layout;
}

/// A ramp as a baseline JPEG, in colour, as a webcam sends it.
Bytes make_jpeg(int width, int height) {
    jpeg_compress_struct jpeg = {};
    jpeg_error_mgr errors = {};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char *memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &memory, &size);
    jpeg.image_width = static_cast<JDIMENSION>(width);
    jpeg.image_height = static_cast<JDIMENSION>(height);
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_YCbCr;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    Bytes row(static_cast<std::size_t>(3 * width), 128);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u)
            row.data()[3 * u] = static_cast<std::uint8_t>(2 * u + v);
        JSAMPROW pixels = row.data();
        jpeg_write_scanlines(&jpeg, &pixels, 1);
    }
    jpeg_finish_compress(&jpeg);
    Bytes bytes(memory, memory + size);
    jpeg_destroy_compress(&jpeg);
    std::free(memory);
    return bytes;
}

bool is_ramp(const Luma &luma) {
    for (int v = 0; v < luma.height(); ++v) {
        for (int u = 0; u < luma.width(); ++u) {
            if (std::abs(luma(u, v) - (2 * u + v)) > 2)
                return false;
        }
    }
    return true;
}

} // namespace

TEST_CASE("luma is read from every uncompressed V4L2 format, without row padding") {
    // Two rows of two pixels, whose luma is 10 20 / 30 40; 99 is anything else.
    struct Format {
        std::uint32_t fourcc;
        std::size_t stride;
        Bytes bytes;
    };
    const Format format =
        GENERATE(Format{V4L2_PIX_FMT_GREY, 3, {10, 20, 99, 30, 40, 99}},
                 Format{V4L2_PIX_FMT_Y16, 4, {99, 10, 99, 20, 99, 30, 99, 40}},
                 Format{V4L2_PIX_FMT_NV12, 2, {10, 20, 30, 40, 99, 99}},
                 Format{V4L2_PIX_FMT_NV12M, 2, {10, 20, 30, 40}},
                 Format{V4L2_PIX_FMT_YUV420, 2, {10, 20, 30, 40, 99, 99}},
                 Format{V4L2_PIX_FMT_YUYV, 6, {10, 99, 20, 99, 99, 99, 30, 99, 40, 99, 99, 99}},
                 Format{V4L2_PIX_FMT_UYVY, 4, {99, 10, 99, 20, 99, 30, 99, 40}});
    const LumaReader read = make_luma_reader(layout_of(format.fourcc, 2, 2, format.stride), -1);
    Luma luma(2, 2);
    CHECK(read(format.bytes, luma) == "");
    CHECK(std::vector<std::uint8_t>(luma.pixels().begin(), luma.pixels().end()) ==
          std::vector<std::uint8_t>{10, 20, 30, 40});
}

TEST_CASE("a V4L2 frame short of pixels is refused, one short of padding is not") {
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_GREY, 2, 2, 3), -1);
    Luma luma(2, 2);
    CHECK(read(Bytes{1, 2, 0, 3, 4}, luma) == "");
    CHECK(read(Bytes{1, 2, 0, 3}, luma) != "");
    CHECK(read(Bytes{}, luma) != "");
}

TEST_CASE("a V4L2 row stride shorter than the row is refused") {
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_YUYV, 2, 2, 2), -1);
    Luma luma(2, 2);
    CHECK(read(Bytes(100), luma) != "");
}

TEST_CASE("a V4L2 JPEG frame is read as luma") {
    const Bytes jpeg = make_jpeg(64, 48);
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_MJPEG, 64, 48, 0), -1);
    Luma luma(64, 48);
    CHECK(read(jpeg, luma) == "");
    CHECK(is_ramp(luma));
}

TEST_CASE("a V4L2 JPEG frame padded with zeros is read") {
    Bytes jpeg = make_jpeg(64, 48);
    jpeg.resize(jpeg.size() + 100);
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_MJPEG, 64, 48, 0), -1);
    Luma luma(64, 48);
    CHECK(read(jpeg, luma) == "");
}

TEST_CASE("a V4L2 JPEG frame without Huffman tables is read") {
    Bytes jpeg = make_jpeg(64, 48);
    for (std::size_t i = 2; i + 3 < jpeg.size() && jpeg[i + 1] != 0xda;) {
        const std::size_t length = 2 + (std::size_t{jpeg[i + 2]} << 8 | jpeg[i + 3]);
        if (jpeg[i + 1] == 0xc4)
            jpeg.erase(jpeg.begin() + static_cast<std::ptrdiff_t>(i),
                       jpeg.begin() + static_cast<std::ptrdiff_t>(i + length));
        else
            i += length;
    }
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_MJPEG, 64, 48, 0), -1);
    Luma luma(64, 48);
    CHECK(read(jpeg, luma) == "");
    CHECK(is_ramp(luma));
}

TEST_CASE("a truncated V4L2 JPEG frame is refused, and the next one is read") {
    const Bytes jpeg = make_jpeg(64, 48);
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_MJPEG, 64, 48, 0), -1);
    Luma luma(64, 48);
    for (std::size_t size = 0; size + 2 < jpeg.size(); size += 7)
        CHECK(read(std::span(jpeg).first(size), luma) != "");
    CHECK(read(jpeg, luma) == "");
    CHECK(is_ramp(luma));
}

TEST_CASE("a V4L2 JPEG frame that is invalid or of another size is refused") {
    const LumaReader read = make_luma_reader(layout_of(V4L2_PIX_FMT_MJPEG, 64, 48, 0), -1);
    Luma luma(64, 48);
    CHECK(read(make_jpeg(32, 48), luma) != "");
    CHECK(read(Bytes(1000, 0xff), luma) != "");
}
