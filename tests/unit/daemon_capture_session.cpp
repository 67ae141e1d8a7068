// SPDX-License-Identifier: Apache-2.0
#include "daemon/capture_session.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"
#include "tests/test_rig.hpp"

#include <sys/eventfd.h>

#include <algorithm>
#include <optional>
#include <utility>

using namespace afterglow;
using namespace std::chrono_literals;
using testing::FakeCameras;

namespace {

Config configured(bool run_without_readers = false) {
    Config config;
    config.daemon.run_without_readers = run_without_readers;
    return config;
}

/// Two cameras of two sizes, of which one is published.
Config configured(PublishedCamera published) {
    Config config;
    config.calibration.rig = testing::test_rig();
    config.published = {published, {90, 91, 49.5, 29.5, 100, 60}};
    return config;
}

/// A session on fake cameras and a clock that the test moves.
struct Fixture {
    explicit Fixture(const Config &config = configured())
        : Fixture(config, rig_geometry(config).value_or(RigGeometry(FakeCameras().camera))) {}
    Fixture(const Config &config, const RigGeometry &geometry)
        : cameras{.camera = geometry.rig.color.pinhole},
          ring(std::move(*RingWriter::create(geometry.published.pinhole, cameras.camera, 2))),
          session(rig, config, pool, *ring, *streams, outbox) {}

    /// One turn, `later` after the one before.
    std::chrono::nanoseconds turn(std::chrono::nanoseconds later = 33ms) {
        now += later;
        return session.turn(orders, now);
    }
    /// The last frame event since the last call.
    std::optional<FrameEvent> last_event() {
        std::optional<FrameEvent> last;
        for (FrameEvent event; outbox.next_frame(event);)
            last = event;
        return last;
    }
    DaemonState state() const { return outbox.state(); }

    FakeCameras cameras;
    Rig rig = cameras.rig();
    WorkerPool pool{1};
    Outbox outbox{UniqueFd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))};
    std::unique_ptr<RingWriter> ring;
    std::unique_ptr<StreamNotifier> streams = std::move(*StreamNotifier::create(*ring));
    CaptureSession session;
    Orders orders = {.policy = {}, .run = true};
    CaptureSession::Time now = CaptureSession::Time(1h);
};

} // namespace

TEST_CASE("the capture session does not start the cameras without readers") {
    Fixture fixture;
    fixture.orders.run = false;
    CHECK(fixture.turn() == CaptureSession::for_ever);
    CHECK(fixture.state() == DaemonState::idle);
    CHECK(fixture.cameras.color_start_count == 0);
}

TEST_CASE("the capture session runs the cameras from the first reader to the last") {
    Fixture fixture;
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
    CHECK(event->missed == 0);
}

TEST_CASE("the cameras go on for a while after the last reader has left") {
    Fixture fixture;
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
    Fixture fixture;
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
    Fixture fixture;
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

TEST_CASE("a frame without depth names no measurement") {
    Fixture fixture;
    fixture.orders.policy.mode = GateMode::off;
    fixture.turn();
    const afterglow_frame frame = fixture.last_event()->frame;
    CHECK(frame.source == AFTERGLOW_NONE);
    CHECK(frame.measurement == AFTERGLOW_NO_MEASUREMENT);
    CHECK(frame.measurement_t_ns == 0);
    CHECK(frame.world == 0);
    CHECK((frame.flags & AFTERGLOW_FRAME_TRACKED) == 0);
}

TEST_CASE("another calibration takes effect without a pause") {
    Fixture fixture;
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
    CHECK(event->missed == 0);
    CHECK(fixture.cameras.color_start_count == 1);
}

TEST_CASE("depth of two cameras is published in the view of the chosen one, lens included") {
    const RigCalibration rig = testing::test_rig();
    const auto [published, camera] = GENERATE_COPY(table<PublishedCamera, CameraModel>(
        {{PublishedCamera::color, rig.color},
         {PublishedCamera::tof, rig.tof},
         {PublishedCamera::pinhole, {.pinhole = {90, 91, 49.5, 29.5, 100, 60}}}}));
    Fixture fixture(configured(published));
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
    const Config config = configured(PublishedCamera::tof);
    Fixture fixture(config);
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

TEST_CASE("both cameras can be lost at once, and each says why") {
    Fixture fixture;
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

TEST_CASE("the capture session charges CPU time while the cameras run, not while they sleep") {
    Fixture fixture;
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
    Fixture fixture(configured(true));
    fixture.orders.run = false;
    CHECK(fixture.turn() == 0ns);
    CHECK(fixture.state() == DaemonState::running);
}

TEST_CASE("the capture session counts dropped images and unusable frames separately") {
    Fixture fixture;
    fixture.turn();
    const auto read = fixture.cameras.read_color;
    fixture.cameras.read_color = [&](ColorFrame &) {
        ++fixture.cameras.sequence; // the device counts it, and we cannot use it
        return Capture::damaged;
    };
    fixture.turn();
    fixture.turn();
    fixture.cameras.read_color = read;
    fixture.cameras.sequence += 3;
    fixture.turn();
    const auto event = fixture.last_event();
    REQUIRE(event);
    CHECK(event->damaged == 2);
    CHECK(event->missed == 3);
    CHECK(event->frame.sequence == 6);
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.sentence() == fixture.cameras.problem);
}

TEST_CASE("the capture session counts depth maps of zeros and keeps the light on") {
    Fixture fixture;
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
    Fixture fixture;
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
    Fixture fixture;
    fixture.turn();
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::none; };
    CHECK(fixture.turn(CaptureSession::color_stall - 1ms) == 0ns);
    CHECK(fixture.state() == DaemonState::running);
    CHECK(fixture.turn(1ms) > 0ns);
    CHECK(fixture.state() == DaemonState::color_lost);
}

TEST_CASE("the capture session does not restart a lost camera without readers") {
    Fixture fixture;
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

TEST_CASE("what depth comes without is noted once, and costs no frame") {
    Fixture fixture;
    fixture.cameras.tof_warning = "depth comes without amplitude";
    fixture.turn();
    Note note;
    REQUIRE(fixture.outbox.next_note(note));
    CHECK(note.priority == Priority::warning);
    CHECK(note.sentence() == "depth comes without amplitude");
    CHECK(fixture.last_event()->frame.source == AFTERGLOW_MEASURED);
    fixture.turn();
    CHECK_FALSE(fixture.outbox.next_note(note));
    CHECK(fixture.last_event()->damaged == 0);
}

TEST_CASE("the capture session publishes images while the TOF camera is lost") {
    Fixture fixture;
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

TEST_CASE("the capture session publishes images when the TOF camera does not start") {
    Fixture fixture;
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
    Fixture fixture;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    for (int frame = 0; frame < 150; ++frame)
        fixture.turn(33ms);
    CHECK(fixture.state() == DaemonState::running);
    for (int frame = 0; frame < 10; ++frame)
        fixture.turn(33ms);
    CHECK(fixture.state() == DaemonState::tof_lost);
    CHECK_FALSE(fixture.cameras.lit);
}

TEST_CASE("the capture session stays stopped and dark after a recording's end") {
    Fixture fixture;
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
        CaptureSession session(rig, configured(), pool, *ring, *streams, outbox);
        session.turn({.policy = {.mode = GateMode::always_on}, .run = true},
                     CaptureSession::Time(1h));
        REQUIRE(cameras.lit);
    }
    CHECK_FALSE(cameras.lit);
    CHECK_FALSE(cameras.color_running);
    CHECK_FALSE(cameras.tof_running);
}
