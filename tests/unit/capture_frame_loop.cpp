// SPDX-License-Identifier: Apache-2.0
#include "capture/frame_loop.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"

using namespace afterglow;
using testing::FakeCameras;

namespace {

/// A started loop on fake cameras.
struct Fixture {
    explicit Fixture(const GatePolicy &policy = {})
        : loop(rig, pipeline_factory({}, pool), policy) {
        REQUIRE(loop.start());
    }
    FrameResult step() { return loop.step(std::chrono::nanoseconds(0)); }

    FakeCameras cameras;
    Rig rig = cameras.rig();
    WorkerPool pool{1};
    FrameLoop loop;
};

} // namespace

TEST_CASE("the frame loop measures the first image and then switches the light off") {
    Fixture fixture;
    const FrameResult first = fixture.step();
    REQUIRE(first.capture == Capture::frame);
    CHECK(first.lit);
    CHECK(first.tof == Capture::frame);
    CHECK(first.estimate.source == FrameSource::measured);
    CHECK(first.estimate.depth(10, 10) == fixture.cameras.depth_mm);
    CHECK_FALSE(fixture.cameras.lit);

    const FrameResult second = fixture.step();
    CHECK_FALSE(second.lit);
    CHECK(second.estimate.source == FrameSource::estimated);
    CHECK_FALSE(fixture.cameras.lit);
}

TEST_CASE("the frame loop makes no unwanted confidences after a change of calibration either") {
    Fixture fixture;
    fixture.loop.want_confidence(false);
    fixture.step();
    CHECK(fixture.step().estimate.confidence.empty());
    fixture.loop.set_geometry(fixture.loop.geometry());
    const FrameResult measured = fixture.step();
    CHECK(measured.estimate.source == FrameSource::measured);
    CHECK(measured.estimate.confidence(10, 10) == measured_confidence);
    const FrameResult estimated = fixture.step();
    CHECK(estimated.estimate.source == FrameSource::estimated);
    CHECK(estimated.estimate.confidence.empty());
}

TEST_CASE("the frame loop makes one depth map in each interval that is wanted") {
    Fixture fixture({.mode = GateMode::interval, .interval_frames = 12});
    fixture.loop.want_depth_every(std::chrono::milliseconds(100));
    std::string maps; // an image each 33 ms: every third has one
    for (int k = 0; k < 24; ++k) {
        const FrameResult result = fixture.step();
        REQUIRE(result.capture == Capture::frame);
        CHECK(result.estimate.tracked);
        maps += result.estimate.depth.empty()                     ? '.'
                : result.estimate.source == FrameSource::measured ? 'm'
                                                                  : 'e';
    }
    CHECK(maps == "me..e..e..e.me..e..e..e.");
    fixture.loop.want_depth_every({});
    CHECK(fixture.step().estimate.source == FrameSource::measured);
    for (int k = 0; k < 3; ++k)
        CHECK_FALSE(fixture.step().estimate.depth.empty());
}

namespace {

/// Its error is 0.4 % times the images since the last measurement.
class Worsening final : public Pipeline {
public:
    explicit Worsening(const Intrinsics &camera) : depth_(camera.width, camera.height, 1500) {}
    const Estimate &track(LumaView /*luma*/, std::int64_t /*t_ns*/) override {
        estimate_.source = FrameSource::estimated;
        ++estimate_.age_frames;
        estimate_.depth = wanted_ ? depth_.view() : DepthView{};
        if (wanted_)
            expect(0.4f * static_cast<float>(estimate_.age_frames));
        return estimate_;
    }
    const Estimate &measure(const Measurement & /*measurement*/) override {
        estimate_.source = FrameSource::measured;
        estimate_.age_frames = 0;
        expect(0);
        estimate_.relative_coverage = 100;
        estimate_.depth = depth_;
        return estimate_;
    }
    void restart() override { estimate_ = {}; }
    void want_depth(bool wanted) override { wanted_ = wanted; }

private:
    void expect(float mre) { estimate_.expected_mre = estimate_.independent_mre = mre; }

    DepthMap depth_;
    Estimate estimate_;
    bool wanted_ = true;
};

} // namespace

TEST_CASE("the frame loop measures the frames that are due, with a TOF camera slow to wake") {
    FakeCameras cameras;
    std::int64_t dark_ns = 0; // the last image in the dark
    cameras.read_tof = [&, read = cameras.read_tof](DepthFrame &frame) {
        const bool awake = cameras.t_ns - dark_ns > 3 * 33'000'000;
        return awake ? read(frame) : Capture::none;
    };
    Rig rig = cameras.rig();
    FrameLoop loop(
        rig,
        [](const RigGeometry &of) { return std::make_unique<Worsening>(of.rig.color.pinhole); },
        {.target_mre = 3, .measurement_price = 0});
    loop.want_depth_every(std::chrono::milliseconds(8 * 33)); // an image each 33 ms
    REQUIRE(loop.start());
    std::string frames;
    while (frames.size() < 34) {
        dark_ns = cameras.lit ? dark_ns : cameras.t_ns;
        const FrameResult result = loop.step(std::chrono::nanoseconds(0));
        REQUIRE(result.capture == Capture::frame);
        frames += result.estimate.source == FrameSource::measured ? 'm'
                  : !result.estimate.depth.empty()                ? 'e'
                  : result.awaited                                ? 'w'
                                                                  : '.';
    }
    // The frame that is due, nine images after a measurement, would miss the target with 3.6 %. How
    // the error grows is not known before the first of them.
    CHECK(frames == "ewwme.......ewwme....wwwme....wwwm");
}

TEST_CASE("the frame loop gives out no maps of images that wait for a measurement") {
    FakeCameras cameras;
    Rig rig = cameras.rig();
    rig.pairing.warmup_maps = 2; // unless what is measured is like the map
    WorkerPool pool(1);
    FrameLoop loop(rig, pipeline_factory({}, pool), GatePolicy{});
    loop.want_depth_every(std::chrono::seconds(1));
    REQUIRE(loop.start());
    const auto step = [&] { return loop.step(std::chrono::nanoseconds(0)); };
    while (step().estimate.source != FrameSource::measured)
        REQUIRE(cameras.sequence < 5);
    CHECK_FALSE(step().estimate.depth.empty()); // the gate compares later ones with it
    CHECK(step().estimate.depth.empty());
    loop.gate().request_measurement();
    const FrameResult asked = step(); // the camera is warming up, and this image has no map
    CHECK(asked.lit);
    CHECK(asked.tof == Capture::none);
    CHECK(asked.estimate.depth.empty());
    SECTION("and the measurement comes") { // after one map instead of two
        CHECK(step().estimate.source == FrameSource::measured);
    }
    SECTION("and no measurement comes") {
        cameras.read_tof = [](DepthFrame &) { return Capture::none; };
        for (int k = 0; k < 2; ++k) {
            const FrameResult waiting = step();
            CHECK(waiting.estimate.source == FrameSource::estimated);
            CHECK(waiting.estimate.depth.empty());
            CHECK(waiting.estimate.confidence.empty());
        }
    }
}

TEST_CASE("the frame loop prepares its pipeline before it waits for the next image") {
    struct Noted final : Pipeline {
        Noted(std::unique_ptr<Pipeline> made, std::string &log)
            : pipeline(std::move(made)), calls(log) {}
        const Estimate &track(LumaView luma, std::int64_t t_ns) override {
            calls += "track ";
            return pipeline->track(luma, t_ns);
        }
        const Estimate &measure(const Measurement &measurement) override {
            calls += "measure ";
            return pipeline->measure(measurement);
        }
        void prepare() override { calls += "prepare "; }
        void restart() override { pipeline->restart(); }
        std::unique_ptr<Pipeline> pipeline;
        std::string &calls;
    };
    FakeCameras cameras;
    std::string calls;
    cameras.read_color = [&, read = cameras.read_color](ColorFrame &frame) {
        calls += "read ";
        return read(frame);
    };
    Rig rig = cameras.rig();
    WorkerPool pool(1);
    const PipelineFactory make = pipeline_factory({}, pool);
    FrameLoop loop(
        rig,
        [&](const RigGeometry &geometry) { return std::make_unique<Noted>(make(geometry), calls); },
        {});
    REQUIRE(loop.start());
    for (int frame = 0; frame < 2; ++frame)
        REQUIRE(loop.step(std::chrono::nanoseconds(0)).capture == Capture::frame);
    CHECK(calls == "prepare read track measure prepare read track ");
}

TEST_CASE("the frame loop keeps the light on until a slow TOF camera has measured") {
    Fixture fixture;
    const auto read = fixture.cameras.read_tof;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    for (int frame = 0; frame < 3; ++frame) {
        const FrameResult result = fixture.step();
        CHECK(result.lit);
        CHECK(result.tof == Capture::none);
        CHECK(result.estimate.source == FrameSource::none);
        CHECK(fixture.cameras.lit);
    }
    fixture.cameras.read_tof = read;
    CHECK(fixture.step().estimate.source == FrameSource::measured);
    CHECK_FALSE(fixture.cameras.lit);
}

TEST_CASE("the frame loop never switches the light in mode always-on") {
    Fixture fixture({GateMode::always_on, 10});
    for (int frame = 0; frame < 3; ++frame) {
        CHECK(fixture.step().estimate.source == FrameSource::measured);
        CHECK(fixture.cameras.lit);
    }
    fixture.loop.gate().set_policy({.mode = GateMode::off});
    CHECK_FALSE(fixture.step().lit);
    CHECK_FALSE(fixture.cameras.lit);
}

TEST_CASE("the frame loop does not take a nearly empty depth map as a measurement") {
    Fixture fixture;
    fixture.cameras.depth_mm = 0;
    const FrameResult result = fixture.step();
    CHECK(result.tof == Capture::damaged);
    CHECK(result.estimate.source == FrameSource::none);
    CHECK_FALSE(result.problem.empty());
    CHECK(fixture.cameras.lit);

    const auto read = fixture.cameras.read_tof;
    fixture.cameras.read_tof = [&](DepthFrame &frame) {
        const Capture capture = read(frame);
        for (int pixel = 0; pixel < 20; ++pixel) // of 64 x 48: 0.65 %
            frame.depth.pixels()[static_cast<std::size_t>(pixel)] = 1000;
        return capture;
    };
    CHECK(fixture.step().tof == Capture::damaged);
    fixture.cameras.depth_mm = 1500;
    CHECK(fixture.step().estimate.source == FrameSource::measured);
}

TEST_CASE("the frame loop does not use a depth map of another time than the image's") {
    Fixture fixture;
    const std::int64_t offset_ms = GENERATE(-16, 16, 33, 1000);
    fixture.cameras.read_tof = [&](DepthFrame &frame) {
        fixture.cameras.give_depth(frame);
        frame.t_ns += offset_ms * 1'000'000;
        return Capture::frame;
    };
    const FrameResult result = fixture.step();
    CHECK(result.tof != Capture::frame);
    CHECK(result.estimate.source == FrameSource::none);
}

TEST_CASE("the frame loop skips old depth maps to reach the image's own") {
    Fixture fixture;
    int maps = 0;
    fixture.cameras.read_tof = [&](DepthFrame &frame) {
        fixture.cameras.give_depth(frame);
        frame.t_ns -= (2 - maps++) * std::int64_t{33'000'000};
        return Capture::frame;
    };
    CHECK(fixture.step().estimate.source == FrameSource::measured);
    CHECK(maps == 3);
}

TEST_CASE("the frame loop drops frames of another size and accepts the next") {
    Fixture fixture;
    const auto read_color = fixture.cameras.read_color;
    fixture.cameras.read_color = [](ColorFrame &frame) {
        frame.luma = Luma(32, 32);
        return Capture::frame;
    };
    CHECK(fixture.step().capture == Capture::damaged);
    CHECK_FALSE(fixture.cameras.lit);
    fixture.cameras.read_color = read_color;

    const auto read_tof = fixture.cameras.read_tof;
    fixture.cameras.read_tof = [&](DepthFrame &frame) {
        frame.depth = DepthMap(32, 32, 1000);
        frame.t_ns = fixture.cameras.t_ns;
        return Capture::frame;
    };
    const FrameResult odd = fixture.step();
    CHECK(odd.capture == Capture::frame);
    CHECK(odd.tof == Capture::damaged);
    CHECK(odd.estimate.source == FrameSource::none);
    fixture.cameras.read_tof = read_tof;
    CHECK(fixture.step().estimate.source == FrameSource::measured);
}

TEST_CASE("the frame loop drops an image whose timestamp does not increase") {
    Fixture fixture;
    fixture.step();
    fixture.cameras.t_ns -= 33'000'000; // the same time again
    CHECK(fixture.step().capture == Capture::damaged);
    fixture.cameras.t_ns -= 50'000'000;
    const FrameResult backwards = fixture.step();
    CHECK(backwards.capture == Capture::damaged);
    CHECK_FALSE(backwards.problem.empty());
    fixture.cameras.t_ns += 100'000'000;
    CHECK(fixture.step().capture == Capture::frame);
}

TEST_CASE("the frame loop does not use depth from before a pause") {
    Fixture fixture;
    fixture.step();
    fixture.loop.stop();
    CHECK_FALSE(fixture.cameras.color_running);
    CHECK_FALSE(fixture.cameras.tof_running);
    REQUIRE(fixture.loop.start());
    fixture.loop.gate().set_policy({.mode = GateMode::off});
    CHECK(fixture.step().estimate.source == FrameSource::none);
}

TEST_CASE("the gate's mode survives a pause of the frame loop") {
    Fixture fixture;
    fixture.loop.gate().set_policy({.mode = GateMode::off});
    fixture.loop.stop();
    REQUIRE(fixture.loop.start());
    CHECK(fixture.loop.gate().policy().mode == GateMode::off);
}

TEST_CASE("when one of the two cameras does not start, neither runs") {
    FakeCameras cameras;
    cameras.tof_starts = Error{"no TOF camera", 0};
    Rig rig = cameras.rig();
    WorkerPool pool(1);
    FrameLoop loop(rig, pipeline_factory({}, pool), {});
    const Status started = loop.start();
    REQUIRE_FALSE(started);
    CHECK(started.error().message == "no TOF camera");
    CHECK_FALSE(cameras.color_running);
}

TEST_CASE("a light that cannot be switched on is reported apart from the TOF camera") {
    Fixture fixture;
    fixture.cameras.light_obeys = Error{"the light is stuck", 0};
    const FrameResult result = fixture.step();
    CHECK(result.capture == Capture::frame);
    CHECK_FALSE(result.lit);
    CHECK(result.tof == Capture::none);
    CHECK(result.light_problem == "the light is stuck");
}

TEST_CASE("a light that cannot be darkened does not hide why the colour camera is lost") {
    Fixture fixture;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    fixture.step();
    REQUIRE(fixture.cameras.lit);
    fixture.cameras.light_obeys = Error{"the light is stuck", 0};
    fixture.cameras.problem = "unplugged";
    fixture.cameras.read_color = [](ColorFrame &) { return Capture::lost; };
    const FrameResult result = fixture.step();
    CHECK(result.problem == "unplugged");
    CHECK(result.light_problem == "the light is stuck");
}

TEST_CASE("the light is switched off when the colour camera is lost") {
    Fixture fixture;
    fixture.cameras.read_tof = [](DepthFrame &) { return Capture::none; };
    fixture.step();
    REQUIRE(fixture.cameras.lit);
    const Capture gone = GENERATE(Capture::lost, Capture::ended);
    fixture.cameras.read_color = [=](ColorFrame &) { return gone; };
    CHECK(fixture.step().capture == gone);
    CHECK_FALSE(fixture.cameras.lit);
}

TEST_CASE("an iteration of the frame loop allocates nothing") {
    Fixture fixture({GateMode::interval, 3});
    for (int frame = 0; frame < 5; ++frame)
        fixture.step();
    const std::uint64_t before = allocation_count();
    for (int frame = 0; frame < 10; ++frame)
        fixture.step();
    CHECK(allocation_count() == before);
}
