// SPDX-License-Identifier: Apache-2.0
// Which view of calibrated cameras is published, and what another calibration changes.
#include "tests/capture_fixture.hpp"
#include "tests/catch.hpp"
#include "tests/test_rig.hpp"

#include <algorithm>

using namespace afterglow;
using testing::CaptureFixture;

namespace {

/// Two cameras of two sizes, of which one is published.
Config two_cameras(PublishedCamera published) {
    Config config;
    config.calibration.rig = testing::test_rig();
    config.published = {published, {90, 91, 49.5, 29.5, 100, 60}};
    return config;
}

} // namespace

TEST_CASE("another calibration takes effect without a pause") {
    CaptureFixture fixture;
    fixture.turn();
    Intrinsics camera = fixture.cameras.camera;
    fixture.orders.geometry = camera;
    fixture.turn();
    CHECK(fixture.last_event()->frame.calibration == 1); // it is the same
    camera.fx += 1;
    fixture.orders.geometry = camera;
    fixture.turn();
    const auto event = fixture.last_event();
    CHECK(event->frame.calibration == 2);
    CHECK(event->frame.fx == camera.fx);
    CHECK(event->frame.world == 2);                   // with another origin, and so another number
    CHECK(event->frame.source == AFTERGLOW_MEASURED); // depth of the camera before is no use
    CHECK(fixture.outbox.losses().missed == 0);
    CHECK(fixture.cameras.color_start_count == 1);
}

TEST_CASE("depth of two cameras is published in the view of the chosen one, lens included") {
    const RigCalibration rig = testing::test_rig();
    const auto [published, camera] = GENERATE_COPY(table<PublishedCamera, CameraModel>(
        {{PublishedCamera::color, rig.color},
         {PublishedCamera::tof, rig.tof},
         {PublishedCamera::pinhole, {.pinhole = {90, 91, 49.5, 29.5, 100, 60}}}}));
    CaptureFixture fixture(two_cameras(published));
    fixture.turn();
    const auto event = fixture.last_event();
    REQUIRE(event);
    const afterglow_frame &frame = event->frame;
    CHECK(frame.source == AFTERGLOW_MEASURED);
    CHECK(frame.coverage > 20); // the other two see more than the TOF camera
    CHECK(frame.fx == camera.pinhole.fx);
    CHECK(frame.fy == camera.pinhole.fy);
    CHECK(frame.cx == camera.pinhole.cx);
    CHECK(frame.cy == camera.pinhole.cy);
    CHECK(frame.lens == static_cast<std::uint32_t>(camera.lens));
    CHECK(std::equal(camera.distortion.begin(), camera.distortion.end(), frame.distortion));
    fixture.turn();
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_ESTIMATED);
}

TEST_CASE("another calibration of two cameras takes effect without a pause") {
    const Config config = two_cameras(PublishedCamera::tof);
    CaptureFixture fixture(config);
    fixture.turn();
    RigCalibration better = *config.calibration.rig;
    better.tof.distortion[0] = -0.08;
    fixture.orders.geometry = RigGeometry(better, better.tof, better.tof_from_color);
    fixture.turn();
    const auto event = fixture.last_event();
    CHECK(event->frame.calibration == 2);
    CHECK(event->frame.distortion[0] == -0.08);
    CHECK(event->frame.world == 2);
    CHECK(event->frame.source == AFTERGLOW_MEASURED);
    CHECK(fixture.cameras.color_start_count == 1);
    fixture.turn();
    CHECK(fixture.last_event()->frame.calibration == 2);
}
