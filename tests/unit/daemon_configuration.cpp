// SPDX-License-Identifier: Apache-2.0
//
// What of a configuration that is read again holds at once.
#include "daemon/configuration.hpp"
#include "tests/catch.hpp"
#include "tests/test_rig.hpp"

using namespace afterglow;
using afterglow::testing::test_rig;

namespace {

using Keys = std::vector<std::string>;

Config real_cameras() {
    Config config;
    config.color.driver = ColorDriver::v4l2;
    config.tof.driver = TofDriver::v4l2;
    config.illuminator.driver = LightDriver::none;
    config.color.camera = {500, 501, 320, 240, 640, 480};
    return config;
}

/// As load_config() leaves it.
Config with_file(const RigCalibration &rig, Config config = real_cameras()) {
    config.calibration.file = "/etc/rig.toml";
    config.calibration.rig = rig;
    config.color.camera = rig.color.pinhole;
    config.tof.delay_ms = 1e3 * rig.tof_delay_s;
    config.tof.registration = false;
    return config;
}

} // namespace

TEST_CASE("the intrinsics of a real colour camera hold without a restart, its size does not") {
    const Config running = real_cameras();
    Config read = running;
    CHECK(restart_needed(running, read).empty());
    read.color.camera.fx = 510;
    read.gate.target_mre = 3;
    const auto geometry = live_geometry(running, read);
    REQUIRE(geometry);
    CHECK(geometry->registered);
    CHECK(geometry->camera() == read.color.camera);
    CHECK(restart_needed(running, read).empty());

    read.color.camera.width = 320;
    CHECK_FALSE(live_geometry(running, read));
    CHECK(restart_needed(running, read) == Keys{"color.width", "color.fx"});
}

TEST_CASE("simulated cameras keep their calibration until a restart") {
    for (const Config &running : {Config{}, with_file(test_rig(), {})}) {
        Config read = running;
        read.color.camera.fx += 1;
        if (read.calibration.rig)
            read.calibration.rig->color.pinhole.fx += 1;
        CHECK_FALSE(live_geometry(running, read));
        CHECK(restart_needed(running, read) ==
              Keys{read.calibration.rig ? "rig.calibration" : "color.fx"});
    }
}

TEST_CASE("a changed calibration file holds without a restart where all sizes stay") {
    const Config running = with_file(test_rig());
    CHECK(restart_needed(running, running).empty());
    RigCalibration better = test_rig();
    better.color.pinhole.fx += 1;
    better.color.distortion[0] -= 0.01;
    better.tof.pinhole.cy -= 2;
    better.tof_from_color.T.x() = -0.05;
    better.readout_s = 0.01;
    const Config read = with_file(better);
    const auto geometry = live_geometry(running, read);
    REQUIRE(geometry);
    CHECK(geometry->rig == better);
    CHECK(geometry->published == better.color);
    CHECK(restart_needed(running, read).empty());

    Config moved = read; // the same in another file
    moved.calibration.file = "/etc/other.toml";
    CHECK(restart_needed(running, moved).empty());
}

TEST_CASE(
    "cameras of other sizes need a restart, and the calibration file is the key that is named") {
    const Config running = with_file(test_rig());
    for (CameraModel RigCalibration::*camera : {&RigCalibration::color, &RigCalibration::tof}) {
        RigCalibration other = test_rig();
        (other.*camera).pinhole.height += 16;
        CHECK_FALSE(live_geometry(running, with_file(other)));
        CHECK(restart_needed(running, with_file(other)) == Keys{"rig.calibration"});
    }
    CHECK_FALSE(live_geometry(running, real_cameras())); // registered from now on
    CHECK(restart_needed(running, real_cameras()) == Keys{"tof.registration", "rig.calibration"});
    CHECK(restart_needed(real_cameras(), running) == Keys{"tof.registration", "rig.calibration"});
}

TEST_CASE("another delay of depth needs a restart, and all else in its file does not wait for it") {
    const Config running = with_file(test_rig());
    RigCalibration other = test_rig();
    other.tof_delay_s += 0.01;
    other.tof.pinhole.fx += 1;
    const auto geometry = live_geometry(running, with_file(other));
    REQUIRE(geometry);
    CHECK(geometry->rig.tof.pinhole.fx == other.tof.pinhole.fx);
    CHECK(geometry->rig.tof_delay_s == test_rig().tof_delay_s); // what it runs with
    CHECK(restart_needed(running, with_file(other)) == Keys{"rig.calibration"});
}

TEST_CASE("another published camera holds without a restart where it has the same size") {
    Config running = with_file(test_rig());
    Config read = running;
    read.published.camera = PublishedCamera::tof;
    CHECK_FALSE(live_geometry(running, read));
    CHECK(restart_needed(running, read) == Keys{"published.camera"});

    read.published = {PublishedCamera::pinhole, {90, 90, 63.5, 47.5, 128, 96}};
    const auto geometry = live_geometry(running, read);
    REQUIRE(geometry);
    CHECK(geometry->published == CameraModel{.pinhole = read.published.pinhole});

    running = read;
    read.published.pinhole.fx = 100;
    CHECK(live_geometry(running, read)->published.pinhole.fx == 100);
    CHECK(restart_needed(running, read).empty());
    read.published.pinhole.width = 64;
    CHECK(restart_needed(running, read) == Keys{"published.width", "published.fx"});
}
