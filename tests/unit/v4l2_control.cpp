// SPDX-License-Identifier: Apache-2.0
#include "drivers/v4l2/v4l2.hpp"
#include "tests/captured_stderr.hpp"
#include "tests/catch.hpp"
#include "tests/fake_v4l2.hpp"

#include <cerrno>
#include <cstring>

using namespace afterglow;

namespace {

v4l2_query_ext_ctrl control(std::uint32_t id, const char *name, std::int64_t maximum,
                            std::uint32_t type = V4L2_CTRL_TYPE_INTEGER) {
    v4l2_query_ext_ctrl about = {};
    about.id = id;
    about.type = type;
    std::strncpy(about.name, name, sizeof about.name - 1);
    about.maximum = maximum;
    return about;
}

/// A flash LED: off, flash, torch; with buttons to strobe it and to stop.
struct Flash {
    static constexpr std::uint32_t mode = V4L2_CID_FLASH_LED_MODE;
    FakeV4l2 kernel;
    V4l2ControlOptions options{"/dev/video0", "led_mode", 2, 0, ""};

    Flash() {
        kernel.controls = {
            control(V4L2_CID_BRIGHTNESS, "Brightness", 255),
            control(mode, "LED Mode", 2, V4L2_CTRL_TYPE_MENU),
            control(V4L2_CID_FLASH_STROBE, "Strobe", 0, V4L2_CTRL_TYPE_BUTTON),
            control(V4L2_CID_FLASH_STROBE_STOP, "Stop Strobe", 0, V4L2_CTRL_TYPE_BUTTON)};
        kernel.values[mode] = 1;
    }
};

} // namespace

TEST_CASE("a V4L2 light is off when made, can be switched, and is off when destroyed") {
    Flash flash;
    {
        auto light = open_v4l2_control(flash.options, flash.kernel);
        REQUIRE(light);
        CHECK(flash.kernel.values[Flash::mode] == 0);
        CHECK((*light)->set(true));
        CHECK((*light)->lit());
        CHECK(flash.kernel.values[Flash::mode] == 2);
    }
    CHECK(flash.kernel.values[Flash::mode] == 0);
}

TEST_CASE("a V4L2 control is found by its number") {
    Flash flash;
    flash.options.control = GENERATE("0x009c0901", "10225921", "LED Mode");
    auto light = open_v4l2_control(flash.options, flash.kernel);
    REQUIRE(light);
    CHECK((*light)->set(true));
    CHECK(flash.kernel.values[Flash::mode] == 2);
}

TEST_CASE("a V4L2 light can have separate on and off buttons") {
    Flash flash;
    flash.options = {"/dev/video0", "strobe", 1, 1, "stop_strobe"};
    auto light = open_v4l2_control(flash.options, flash.kernel);
    REQUIRE(light);
    CHECK(flash.kernel.values.count(V4L2_CID_FLASH_STROBE) == 0);
    CHECK(flash.kernel.values.count(V4L2_CID_FLASH_STROBE_STOP) == 1);
    CHECK((*light)->set(true));
    CHECK(flash.kernel.values.count(V4L2_CID_FLASH_STROBE) == 1);
}

TEST_CASE("a V4L2 light control that is missing, read-only or out of range is refused") {
    Flash flash;
    SECTION("no such name") {
        flash.options.control = "torch";
    }
    SECTION("no such number") {
        flash.options.control = "0x1";
    }
    SECTION("too large a value") {
        flash.options.on = 3;
    }
    SECTION("too small a value") {
        flash.options.off = -1;
    }
    SECTION("read-only") {
        flash.kernel.controls[1].flags = V4L2_CTRL_FLAG_READ_ONLY;
    }
    SECTION("no control named") {
        flash.options.control.clear();
    }
    const auto light = open_v4l2_control(flash.options, flash.kernel);
    REQUIRE_FALSE(light);
    CHECK_FALSE(light.error().message.empty());
}

TEST_CASE("a V4L2 light whose device is missing is found when it appears") {
    Flash flash;
    flash.kernel.node.clear();
    auto light = open_v4l2_control(flash.options, flash.kernel);
    REQUIRE(light);
    CHECK_FALSE((*light)->set(true));
    CHECK_FALSE((*light)->lit());
    flash.kernel.node = "/dev/video0";
    CHECK((*light)->set(true));
    CHECK(flash.kernel.values[Flash::mode] == 2);
}

TEST_CASE("a V4L2 light that fails keeps its state and is reopened for the next order") {
    Flash flash;
    auto light = open_v4l2_control(flash.options, flash.kernel);
    REQUIRE(light);
    flash.kernel.failing[VIDIOC_S_EXT_CTRLS] = ENODEV;
    CHECK_FALSE((*light)->set(true));
    CHECK_FALSE((*light)->lit());
    flash.kernel.failing.clear();
    CHECK((*light)->set(true));
    CHECK(flash.kernel.opened == 2);
}

TEST_CASE("a V4L2 light that cannot be darkened at its end is logged, an absent one is not") {
    Flash flash;
    const CapturedStderr captured;
    {
        const auto absent = open_v4l2_control({"/dev/video9", "led_mode", 2, 0, ""}, flash.kernel);
        REQUIRE(absent);
    }
    CHECK(captured.text().empty());
    {
        const auto light = open_v4l2_control(flash.options, flash.kernel);
        REQUIRE(light);
        REQUIRE((*light)->set(true));
        flash.kernel.failing[VIDIOC_S_EXT_CTRLS] = EIO;
    }
    CHECK(captured.text().find("the illuminator may still be lit: the camera '/dev/video0' failed "
                               "to switch its light: Input/output error\n") != std::string::npos);
}
