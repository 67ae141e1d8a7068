// SPDX-License-Identifier: Apache-2.0
// Cameras that fail, fall silent or bring nothing usable.
#include "tests/capture_fixture.hpp"
#include "tests/catch.hpp"

using namespace afterglow;
using namespace std::chrono_literals;
using testing::CaptureFixture;

TEST_CASE("both cameras can be lost at once, and each says why") {
    CaptureFixture fixture;
    fixture.cameras.tof_starts = Error{"no TOF camera", 0};
    fixture.turn();
    CHECK(fixture.outbox.cameras() == CameraStates{CameraState::running, CameraState::lost});
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::lost; };
    fixture.turn(10ms);
    CHECK(fixture.outbox.cameras() == CameraStates{CameraState::lost, CameraState::lost});
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.lost == Camera::tof);
    CHECK(note.sentence() == "no TOF camera");
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.lost == Camera::color);
    CHECK(note.sentence() == fixture.cameras.problem);
}

TEST_CASE("the capture session counts dropped images and unusable frames separately") {
    CaptureFixture fixture;
    fixture.turn();
    const auto read = fixture.cameras.read_color;
    fixture.cameras.read_color = [&](ColorFrame &) {
        ++fixture.cameras.sequence; // the device counts it, and we cannot use it
        return Capture::damaged;
    };
    fixture.turn();
    fixture.turn();
    CHECK(fixture.outbox.losses().damaged == 2); // although no frame is published
    fixture.cameras.read_color = read;
    fixture.cameras.sequence += 3;
    fixture.turn();
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(fixture.outbox.losses().damaged == 2);
    CHECK(fixture.outbox.losses().missed == 3);
    CHECK(event->frame.sequence == 6);
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.sentence() == fixture.cameras.problem);
}

TEST_CASE("the capture session counts depth maps of zeros and keeps the light on") {
    CaptureFixture fixture;
    fixture.cameras.depth_mm = 0;
    for (int frame = 0; frame < 300; ++frame)
        fixture.turn();
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(event->frame.source == AFTERGLOW_NONE);
    CHECK(event->frame.emitter == AFTERGLOW_EMITTER_ON);
    CHECK(fixture.state() == DaemonState::running);
    CHECK(fixture.cameras.lit);
}

TEST_CASE("the capture session restarts a lost colour camera at growing intervals") {
    CaptureFixture fixture;
    fixture.turn();
    const auto read = fixture.cameras.read_color;
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::lost; };
    CHECK(fixture.turn() == 250ms);
    CHECK(fixture.state() == DaemonState::color_lost);
    CHECK_FALSE(fixture.cameras.lit);
    CHECK_FALSE(fixture.cameras.tof_running);
    CHECK(fixture.cameras.color_start_count == 1);

    CHECK(fixture.turn(100ms) == 150ms); // woken early, by an order
    CHECK(fixture.cameras.color_start_count == 1);

    fixture.cameras.color_starts = Error{"no such device", 0};
    CHECK(fixture.turn(150ms) == 500ms);
    CHECK(fixture.turn(500ms) ==
          500ms); // and no less: a camera is used within two seconds of its return
    CHECK(fixture.state() == DaemonState::color_lost);

    fixture.cameras.color_starts = ok();
    fixture.cameras.read_color = read;
    CHECK(fixture.turn(500ms) == 0ns);
    CHECK(fixture.state() == DaemonState::running);
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::lost; };
    CHECK(fixture.turn() == 250ms);
}

TEST_CASE("the capture session declares a silent colour camera lost") {
    CaptureFixture fixture;
    fixture.turn();
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::none; };
    CHECK(fixture.turn(CaptureSession::color_stall - 1ms) == 0ns);
    CHECK(fixture.state() == DaemonState::running);
    CHECK(fixture.turn(1ms) > 0ns);
    CHECK(fixture.state() == DaemonState::color_lost);
}

TEST_CASE("the capture session does not restart a lost camera without readers") {
    CaptureFixture fixture;
    fixture.cameras.color_starts = Error{"no such device", 0};
    fixture.turn();
    REQUIRE(fixture.state() == DaemonState::color_lost);
    fixture.orders.run = false;
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.state() == DaemonState::idle);
    fixture.orders.run = true;
    fixture.cameras.color_starts = ok();
    CHECK(fixture.turn() == 0ns); // at once, whatever the back-off was
    CHECK(fixture.state() == DaemonState::running);
}

TEST_CASE("the capture session publishes images while the TOF camera is lost") {
    CaptureFixture fixture;
    fixture.turn();
    const auto read = fixture.cameras.read_tof;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::lost; };
    fixture.orders.policy.mode = GateMode::always_on;
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::tof_lost);
    CHECK_FALSE(fixture.cameras.lit);
    CHECK_FALSE(fixture.cameras.tof_running);
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_ESTIMATED);

    fixture.turn(10ms); // too early to try again
    CHECK(fixture.cameras.tof_start_count == 1);
    CHECK(fixture.last_event()->frame.emitter == AFTERGLOW_EMITTER_OFF);

    fixture.turn(240ms); // starts, and is lost again
    CHECK(fixture.cameras.tof_start_count == 2);
    CHECK(fixture.state() == DaemonState::tof_lost);

    fixture.cameras.read_tof = read;
    fixture.turn(500ms);
    CHECK(fixture.state() == DaemonState::running);
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_MEASURED);
}

TEST_CASE("a frame that was measured says so, though the light then failed to go dark") {
    CaptureFixture fixture;
    fixture.cameras.read_tof = [&](DepthFrame &frame) {
        fixture.cameras.give_depth(frame);
        fixture.cameras.light_obeys = Error{"the light is stuck", 0};
        return Capture::frame;
    };
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::tof_lost);
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(event->frame.source == AFTERGLOW_MEASURED);
    CHECK(event->frame.measurement == 0);
    CHECK(event->frame.measurement_t_ns == event->frame.t_ns);
    CHECK(event->pairing_error_ns == 0);
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.sentence() == "the light is stuck");
    CHECK(note.lost == Camera::tof);
}

TEST_CASE("the capture session publishes images when the TOF camera does not start") {
    CaptureFixture fixture;
    fixture.cameras.tof_starts = Error{"no TOF camera", 0};
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::tof_lost);
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(event->frame.source == AFTERGLOW_NONE);
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.sentence() == "no TOF camera");
}

TEST_CASE("the capture session restarts a TOF camera that is lit and silent") {
    CaptureFixture fixture;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    for (int frame = 0; frame < 150; ++frame)
        fixture.turn(33ms);
    CHECK(fixture.state() == DaemonState::running);
    for (int frame = 0; frame < 10; ++frame)
        fixture.turn(33ms);
    CHECK(fixture.state() == DaemonState::tof_lost);
    CHECK_FALSE(fixture.cameras.lit);
}
