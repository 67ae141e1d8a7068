// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/list.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <cstring>

using namespace afterglow;

namespace {

v4l2_query_ext_ctrl control(std::uint32_t id, const char *name, std::uint32_t flags = 0) {
    v4l2_query_ext_ctrl about = {};
    about.id = id;
    about.type = V4L2_CTRL_TYPE_INTEGER;
    about.maximum = 2;
    about.flags = flags;
    std::strncpy(about.name, name, sizeof about.name - 1);
    return about;
}

} // namespace

TEST_CASE("a V4L2 camera is listed with its readable formats") {
    FakeV4l2 kernel;
    kernel.formats = {{V4L2_PIX_FMT_YUYV, 640, 480, 30, 2},
                      {V4L2_PIX_FMT_H264, 640, 480, 30},
                      {V4L2_PIX_FMT_Z16, 320, 240, 15, 2}};
    const auto listings = list_v4l2_devices(kernel);
    REQUIRE(listings.size() == 1);
    CHECK(listings[0].path == "/dev/video0");
    CHECK(listings[0].stable_name == "usb-fake-1");
    REQUIRE(listings[0].modes.size() == 2);
    CHECK(listings[0].modes[0].format == "YUYV");
    CHECK(listings[0].modes[0].width == 640);
    CHECK(listings[0].modes[0].fps == 30);
    CHECK_FALSE(listings[0].modes[0].is_depth);
    CHECK(listings[0].modes[1].format == "Z16");
    CHECK(listings[0].modes[1].is_depth);
}

TEST_CASE("V4L2 controls that may switch a light are recognised by name") {
    FakeV4l2 kernel;
    kernel.controls = {control(1, "Brightness"), control(2, "Enabled Filters"),
                       control(3, "LED Mode"), control(4, "Laser Power", V4L2_CTRL_FLAG_READ_ONLY),
                       control(5, "Illumination On")};
    const auto listings = list_v4l2_devices(kernel);
    REQUIRE(listings.size() == 1);
    REQUIRE(listings[0].lights.size() == 2);
    CHECK(listings[0].lights[0].name == "led_mode");
    CHECK(listings[0].lights[0].maximum == 2);
    CHECK(listings[0].lights[1].name == "illumination_on");
}

TEST_CASE("a V4L2 node without capture and light is not listed") {
    FakeV4l2 kernel;
    kernel.caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
    CHECK(list_v4l2_devices(kernel).empty());
    kernel.node.clear();
    CHECK(list_v4l2_devices(kernel).empty());
}
