// SPDX-License-Identifier: Apache-2.0
#include "daemon/capture_session.hpp"
#include "tests/capture_fixture.hpp"
#include "tests/catch.hpp"

#include <sys/eventfd.h>

#include <utility>

using namespace afterglow;
using namespace std::chrono_literals;
using testing::CaptureFixture;
using testing::FakeCameras;

TEST_CASE("the capture session does not start the cameras without readers") {
    CaptureFixture fixture;
    fixture.orders.run = false;
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.state() == DaemonState::idle);
    CHECK(fixture.cameras.color_start_count == 0);
}

TEST_CASE("the capture session runs the cameras from the first reader to the last") {
    CaptureFixture fixture;
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::running);
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_MEASURED);
    fixture.turn();
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_ESTIMATED);

    fixture.orders.run = false;
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.state() == DaemonState::idle);
    CHECK_FALSE(fixture.cameras.color_running);
    CHECK_FALSE(fixture.cameras.tof_running);
    CHECK_FALSE(fixture.cameras.lit);

    fixture.orders.run = true;
    CHECK(fixture.turn(1min) == 0ns);
    CHECK(fixture.state() == DaemonState::running);
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(event->frame.index == 2);
    CHECK(event->frame.source == AFTERGLOW_MEASURED);
    CHECK(fixture.outbox.losses().missed == 0);
}

TEST_CASE("the cameras go on for a while after the last reader has left") {
    CaptureFixture fixture;
    fixture.orders.linger_s = 2;
    fixture.turn();
    fixture.orders.run = false;
    CHECK(fixture.turn(1s) == 0ns);
    CHECK(fixture.cameras.color_running);
    SECTION("and sleep when nobody comes") {
        CHECK(fixture.turn(1s) == CaptureSession::for_ever);
        CHECK_FALSE(fixture.cameras.color_running);
        CHECK(fixture.state() == DaemonState::idle);
    }
    SECTION("and a reader that comes back finds them tracking") {
        fixture.orders.run = true;
        CHECK(fixture.turn() == 0ns);
        fixture.orders.run = false;
        CHECK(fixture.turn(1900ms) == 0ns);
        CHECK(fixture.cameras.color_start_count == 1);
        CHECK(fixture.last_event()->frame.source == AFTERGLOW_ESTIMATED);
    }
}

TEST_CASE("readers that come and go do not buy light beyond the budget") {
    CaptureFixture fixture;
    fixture.orders.policy.duty_cycle_budget = 2;
    int lit = 0;
    for (int visit = 0; visit < 400; ++visit) {
        fixture.orders.run = true;
        for (int frame = 0; frame < 2; ++frame) {
            fixture.turn();
            lit += fixture.last_event()->frame.emitter == AFTERGLOW_EMITTER_ON;
        }
        fixture.orders.run = false;
        fixture.turn();
        REQUIRE(fixture.state() == DaemonState::idle);
    }
    CHECK(lit >= 6);
    CHECK(lit <= 800 * 2 / 100 + 6 + 1); // the budget, what may be saved up, and a wake
}

TEST_CASE("the ring says which measurement a frame rests on, and where the camera is") {
    CaptureFixture fixture;
    fixture.turn();
    const afterglow_frame first = fixture.last_event()->frame;
    CHECK(first.measurement == 0);
    CHECK(first.measurement_t_ns == first.t_ns);
    CHECK(first.flags == (AFTERGLOW_FRAME_TRACKED | AFTERGLOW_FRAME_FIRST));
    CHECK(first.emitter == AFTERGLOW_EMITTER_ON);
    CHECK(first.world == 1);
    CHECK(first.calibration == 1);
    CHECK(first.fx == fixture.cameras.camera.fx);

    fixture.turn();
    const afterglow_frame second = fixture.last_event()->frame;
    CHECK(second.measurement == 0);
    CHECK(second.measurement_t_ns == first.t_ns);
    CHECK(second.flags == AFTERGLOW_FRAME_TRACKED);
    CHECK(second.emitter == AFTERGLOW_EMITTER_OFF);
    CHECK(second.world == 1);

    ++fixture.orders.measurements;
    fixture.turn();
    const auto requested = fixture.last_event();
    CHECK(requested->reason == GateReason::requested);
    CHECK(requested->frame.measurement == 1);
    CHECK(requested->frame.tof_sequence > first.tof_sequence);
    CHECK(requested->frame.world == 1);

    fixture.orders.run = false;
    fixture.turn();
    fixture.orders.run = true;
    fixture.turn();
    const afterglow_frame woken = fixture.last_event()->frame;
    CHECK(woken.measurement == 2);
    CHECK(woken.world == 2);
    CHECK((woken.flags & AFTERGLOW_FRAME_FIRST) != 0);
}

TEST_CASE("the capture session counts images without a frame, and those of them that were lit") {
    CaptureFixture fixture;
    fixture.orders.policy = {.mode = GateMode::interval, .interval_frames = 20};
    fixture.ring->want_interval(200ms); // every sixth image
    fixture.turn();
    CHECK(fixture.last_event()->skipped == 0);
    fixture.turn();
    for (int k = 0; k < 5; ++k)
        fixture.turn();
    CHECK(fixture.last_event()->frame.index == 1);
    fixture.turn();
    const auto third = fixture.last_event();
    REQUIRE(third);
    CHECK(third->frame.index == 2);
    CHECK(third->frame.sequence == 7);
    CHECK(third->skipped == 5);
    CHECK(third->skipped_lit == 0);
    CHECK(fixture.outbox.losses().missed == 0);
    CHECK(third->stream_ns == 7 * 33'000'000);

    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    fixture.turn();
    fixture.orders.measurements = 1;
    fixture.turn(); // asks for light; no frame is due
    CHECK_FALSE(fixture.last_event());
    for (int k = 0; k < 3; ++k) {
        fixture.turn(); // waits for the measurement; no frame is due
        CHECK_FALSE(fixture.last_event());
    }
    fixture.turn();
    const auto lit = fixture.last_event();
    REQUIRE(lit);
    CHECK(lit->frame.emitter == AFTERGLOW_EMITTER_ON);
    CHECK(lit->frame.sequence == 13);
    CHECK(lit->skipped == 5);
    CHECK(lit->skipped_lit == 4);
}

TEST_CASE("a frame without depth names no measurement") {
    CaptureFixture fixture;
    fixture.orders.policy.mode = GateMode::off;
    fixture.turn();
    const afterglow_frame frame = fixture.last_event()->frame;
    CHECK(frame.source == AFTERGLOW_NONE);
    CHECK(frame.measurement == AFTERGLOW_NO_MEASUREMENT);
    CHECK(frame.measurement_t_ns == 0);
    CHECK(frame.world == 0);
    CHECK((frame.flags & AFTERGLOW_FRAME_TRACKED) == 0);
}

TEST_CASE("the capture session charges CPU time while the cameras run, not while they sleep") {
    CaptureFixture fixture;
    fixture.turn();
    CHECK(fixture.last_event()->stream_ns == 0); // no image before it
    fixture.turn();
    const auto running = fixture.last_event();
    CHECK(running->stream_ns == 33'000'000);
    CHECK(running->cpu_ns > 0);

    fixture.orders.run = false;
    fixture.turn();
    fixture.cameras.t_ns += 60'000'000'000;
    fixture.orders.run = true;
    fixture.turn(1min);
    const auto woken = fixture.last_event();
    CHECK(woken->stream_ns == running->stream_ns);
    CHECK(woken->cpu_ns == running->cpu_ns);
}

TEST_CASE("the capture session runs without readers when configured so") {
    Config config;
    config.daemon.run_without_readers = true;
    CaptureFixture fixture(config);
    fixture.orders.run = false;
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::running);
}

TEST_CASE("what depth comes without is noted once, and costs no frame") {
    CaptureFixture fixture;
    fixture.cameras.tof_warning = "depth comes without amplitude";
    fixture.turn();
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.priority == Priority::warning);
    CHECK(note.sentence() == "depth comes without amplitude");
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_MEASURED);
    fixture.turn();
    CHECK_FALSE(fixture.outbox.next_note(note));
    CHECK(fixture.outbox.losses().damaged == 0);
}

TEST_CASE("the capture session stays stopped and dark after a recording's end") {
    CaptureFixture fixture;
    fixture.turn();
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::ended; };
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.state() == DaemonState::stopped);
    CHECK_FALSE(fixture.cameras.color_running);
    CHECK_FALSE(fixture.cameras.lit);
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.cameras.color_start_count == 1);
}

TEST_CASE("the capture session stops the cameras and the light when destroyed") {
    FakeCameras cameras;
    {
        Rig rig = cameras.rig();
        WorkerPool pool(1);
        Outbox outbox{UniqueFd(::eventfd(0, EFD_NONBLOCK))};
        const auto ring = std::move(*RingWriter::create(cameras.camera, 2));
        const auto streams = std::move(*StreamNotifier::create(*ring));
        CaptureSession session(rig, {}, pool, *ring, *streams, outbox);
        session.turn({.policy = {.mode = GateMode::always_on}, .run = true},
                     CaptureSession::Time(1h));
        REQUIRE(cameras.lit);
    }
    CHECK_FALSE(cameras.lit);
    CHECK_FALSE(cameras.color_running);
    CHECK_FALSE(cameras.tof_running);
}
