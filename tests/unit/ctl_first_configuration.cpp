// SPDX-License-Identifier: Apache-2.0
#include "config/config.hpp"
#include "tests/catch.hpp"
#include "tests/program.hpp"
#include "tools/ctl/devices.hpp"

using namespace afterglow;

namespace {

FoundDevices a_webcam_and_an_xtion() {
    FoundDevices found;
    found.color = {{"v4l2", "usb \"cam\"", "Cam", "YUYV 320x240 at 30", 320, 240, 30}};
    found.tof = {{"openni2", "1d27/0600@1/2", "Xtion", "640x480 at 30, 1 mm", false}};
    found.lights = {
        {"led", "caps", "LED", "on = 1\n"},
        {"openni2-emitter", "", "Xtion", "property = 0x1080E007\npayload = \"uint64\"\n"}};
    return found;
}

Config load(const FoundDevices &found) {
    const Result<std::string> text = first_configuration(found);
    REQUIRE(text);
    const TemporaryFolder folder;
    Result<Config> config = load_config(folder.write("a.toml", *text));
    INFO(*text);
    REQUIRE(config);
    return *std::move(config);
}

} // namespace

TEST_CASE("afterglowctl probe writes a configuration that afterglowd accepts") {
    const Config config = load(a_webcam_and_an_xtion());
    CHECK(config.color.driver == ColorDriver::v4l2);
    CHECK(config.color.device == "usb \"cam\"");
    CHECK(config.color.camera == Intrinsics{262.5, 262.5, 159.5, 119.5, 320, 240});
    CHECK(config.tof.driver == TofDriver::openni2);
    CHECK(config.tof.device == "1d27/0600@1/2");
    CHECK_FALSE(config.tof.registration);
    CHECK(config.illuminator.driver == LightDriver::openni2_emitter);
}

TEST_CASE("afterglowctl probe configures only a light that is known to belong to the TOF camera") {
    FoundDevices found = a_webcam_and_an_xtion();
    found.lights = {{"led", "caps", "LED", "on = 1\n"},
                    {"v4l2-control", "other", "Cam", "control = \"led_mode\"\n"}};
    found.tof = {{"v4l2", "tof", "TOF", "Z16 320x240", true}};
    CHECK(load(found).illuminator.driver == LightDriver::none);
    found.lights.push_back({"v4l2-control", "tof", "TOF", "control = \"led_mode\"\n"});
    const Config config = load(found);
    CHECK(config.illuminator.driver == LightDriver::v4l2_control);
    CHECK(config.illuminator.device == "tof");
}

TEST_CASE(
    "a line break in a device's name adds no line to the configuration of afterglowctl probe") {
    FoundDevices found = a_webcam_and_an_xtion();
    found.color.front().title = "Cam\n[color]\nfps = 1";
    found.tof.front().title = "Xtion\nwrong = 1";
    CHECK(load(found).color.fps == Approx(30));
}

TEST_CASE("afterglowctl probe writes no configuration without both cameras") {
    FoundDevices found = a_webcam_and_an_xtion();
    found.tof.clear();
    CHECK(first_configuration(found).error().message == "there is no TOF camera");
    found.color.clear();
    CHECK(first_configuration(found).error().message == "there is no colour camera");
}
