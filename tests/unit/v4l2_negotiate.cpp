// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/device.hpp"
#include "drivers/v4l2/luma_reader.hpp"
#include "drivers/v4l2/negotiate.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <cerrno>

using namespace afterglow;
using namespace afterglow::v4l2;

namespace {

constexpr std::uint32_t grey = V4L2_PIX_FMT_GREY;
constexpr std::uint32_t yuyv = V4L2_PIX_FMT_YUYV;
constexpr std::uint32_t mjpeg = V4L2_PIX_FMT_MJPEG;

Result<FrameLayout> negotiate_640x480(FakeV4l2 &kernel, double fps = 30) {
    return negotiate(kernel, 0, {"cam", 640, 480, fps, luma_formats()});
}

} // namespace

TEST_CASE("V4L2 negotiation takes the format with the cheapest luma") {
    FakeV4l2 kernel;
    kernel.formats = {{mjpeg, 640, 480, 30}, {yuyv, 640, 480, 30, 2}, {grey, 640, 480, 30}};
    const auto layout = negotiate_640x480(kernel);
    REQUIRE(layout);
    CHECK(layout->fourcc == grey);
    CHECK(layout->stride == 640);
    CHECK(layout->period_ns == 33'333'333);
}

TEST_CASE(
    "V4L2 negotiation takes a costlier format when the cheaper is too slow or of another size") {
    FakeV4l2 kernel;
    kernel.formats = {{grey, 320, 240, 30}, {yuyv, 640, 480, 15, 2}, {mjpeg, 640, 480, 30}};
    const auto layout = negotiate_640x480(kernel);
    REQUIRE(layout);
    CHECK(layout->fourcc == mjpeg);
}

TEST_CASE("V4L2 negotiation takes the fastest format when none reaches the rate") {
    FakeV4l2 kernel;
    kernel.formats = {{yuyv, 640, 480, 5, 2}, {mjpeg, 640, 480, 60}};
    const auto layout = negotiate_640x480(kernel, 120);
    REQUIRE(layout);
    CHECK(layout->fourcc == mjpeg);
}

TEST_CASE("V4L2 negotiation works with a driver that lists no sizes or rates") {
    FakeV4l2 kernel;
    kernel.formats = {{grey, 640, 480, 30}};
    kernel.failing[VIDIOC_ENUM_FRAMESIZES] = ENOTTY;
    kernel.failing[VIDIOC_ENUM_FRAMEINTERVALS] = ENOTTY;
    CHECK(negotiate_640x480(kernel));
    kernel.formats = {{grey, 320, 240, 30}};
    CHECK_FALSE(negotiate_640x480(kernel)); // it gives what it has, which is not what was asked
}

TEST_CASE("a V4L2 camera without a usable format is refused with those it has") {
    FakeV4l2 kernel;
    kernel.formats = {{V4L2_PIX_FMT_H264, 640, 480, 30}, {V4L2_PIX_FMT_Y16_BE, 640, 480, 30}};
    const auto layout = negotiate_640x480(kernel);
    REQUIRE_FALSE(layout);
    CHECK(layout.error().message.find("H264, Y16-BE") != std::string::npos);
}

TEST_CASE("interlaced V4L2 images are refused") {
    FakeV4l2 kernel;
    kernel.formats = {{grey, 640, 480, 30}};
    kernel.field = V4L2_FIELD_INTERLACED;
    CHECK_FALSE(negotiate_640x480(kernel));
}

TEST_CASE("a V4L2 device without streaming capture is refused") {
    FakeV4l2 kernel;
    kernel.formats = {{grey, 640, 480, 30}};
    kernel.caps = GENERATE(V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING,
                           V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE);
    CHECK_FALSE(negotiate_640x480(kernel));
}

TEST_CASE("a file that is no V4L2 device is refused as such") {
    FakeV4l2 kernel;
    kernel.failing[VIDIOC_QUERYCAP] = ENOTTY;
    const auto layout = negotiate_640x480(kernel);
    REQUIRE_FALSE(layout);
    CHECK(layout.error().message.find("no V4L2 device") != std::string::npos);
}

TEST_CASE("a V4L2 device is found by path, by-id name and bus information only") {
    FakeV4l2 kernel;
    CHECK(open_device(kernel, "/dev/video0"));
    CHECK(open_device(kernel, "usb-fake-1"));
    CHECK_FALSE(open_device(kernel, "usb-fake"));
    CHECK_FALSE(open_device(kernel, "video0"));
    kernel.node = "/dev/v4l/by-id/usb-Fake-index0";
    CHECK(open_device(kernel, "usb-Fake-index0"));
}

TEST_CASE("a V4L2 metadata node with the camera's bus information is skipped") {
    FakeV4l2 kernel;
    kernel.caps = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    const auto found = open_device(kernel, "usb-fake-1");
    REQUIRE_FALSE(found);
    CHECK(found.error().code == ENOENT);
}

TEST_CASE("a V4L2 camera that is looked for by name says which node could not be asked") {
    FakeV4l2 kernel;
    kernel.refusing = EACCES;
    const auto found = open_device(kernel, "usb-fake-1");
    REQUIRE_FALSE(found);
    CHECK(found.error().code == ENOENT); // as far as one can know
    CHECK(found.error().message == "no camera that can be opened is called 'usb-fake-1'; of the "
                                   "others: the camera '/dev/video0' may not be used by this user "
                                   "(group video)");
}

TEST_CASE("a V4L2 driver that tells no capabilities of its node is found by name, too") {
    FakeV4l2 kernel;
    kernel.tells_device_caps = false;
    CHECK(open_device(kernel, "usb-fake-1"));
}

TEST_CASE("V4L2 format codes convert to names and back") {
    for (const std::uint32_t fourcc : {grey, yuyv, mjpeg, V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_Y16_BE})
        CHECK(fourcc_from_string(to_string(fourcc)) == fourcc);
    CHECK(fourcc_from_string("") == 0);
    CHECK(fourcc_from_string("YUYV2") == 0);
    CHECK(fourcc_from_string("\x01YUV") == 0);
}
