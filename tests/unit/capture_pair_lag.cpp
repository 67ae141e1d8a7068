// SPDX-License-Identifier: Apache-2.0
//
// When depth maps were exposed, by the stamps of maps and images.
#include "capture/frame_loop.hpp"
#include "capture/pair_lag.hpp"
#include "drivers/simulated/sequence_rig.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/fake_cameras.hpp"
#include "tests/film.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t image_ns = 5'000 * ms;

/// After a first pair whose map is so much later than its image.
PairLag registered_after(std::int64_t late_ns) {
    PairLag lag(true);
    lag.add_pair(image_ns, image_ns + late_ns);
    return lag;
}

} // namespace

TEST_CASE("the lag of two calibrated cameras is the difference of their stamps") {
    PairLag lag(false);
    for (const std::int64_t late : {14 * ms, -15 * ms, 0 * ms}) {
        CHECK(lag.of(image_ns, image_ns + late) == Approx(1e-9 * static_cast<double>(late)));
        lag.add_pair(image_ns, image_ns + late);
    }
}

TEST_CASE("constant offset and jitter of the stamps of registered depth count as no lag") {
    CHECK(PairLag(true).of(image_ns, image_ns + 14 * ms) == 0);
    const PairLag lag = registered_after(14 * ms);
    for (const std::int64_t late : {14 * ms, 2 * ms, 26 * ms})
        CHECK(lag.of(image_ns, image_ns + late) == 0);
}

TEST_CASE("a registered depth map stamped a frame earlier than usual has a negative lag") {
    PairLag lag = registered_after(14 * ms);
    CHECK(lag.of(image_ns, image_ns - 15 * ms) == Approx(-0.029));
    for (int i = 0; i < 50; ++i)
        lag.add_pair(image_ns, image_ns - 15 * ms); // does not become usual
    CHECK(lag.of(image_ns, image_ns - 15 * ms) == Approx(-0.029));
    CHECK(lag.of(image_ns, image_ns + 14 * ms) == 0);
}

TEST_CASE("a slow drift of the stamps of registered depth counts as no lag") {
    PairLag lag = registered_after(14 * ms);
    for (int i = 0; i < 200; ++i) {
        const std::int64_t late = 14 * ms - i * ms / 4; // to -36 ms
        CHECK(lag.of(image_ns, image_ns + late) == 0);
        lag.add_pair(image_ns, image_ns + late);
    }
    CHECK(lag.of(image_ns, image_ns + 14 * ms) > 0.02);
}

namespace {

/// A room before a camera that looks to and fro. Of three maps two are exposed 14 ms after their
/// image and the third 15 ms before it. `stamped`: their stamps say so.
class UnevenPairs final : public FrameSequence {
public:
    explicit UnevenPairs(bool stamped)
        : stamped_(stamped), images_(look(0)), later_(look(0.014)), earlier_(look(-0.015)) {}

    static constexpr int frames = 90;
    const Intrinsics &intrinsics() const override { return images_.camera; }
    std::optional<std::int64_t> time_ns(std::uint64_t k) const override {
        if (k >= frames)
            return std::nullopt;
        return static_cast<std::int64_t>(k) * Viewer::frame_ns;
    }
    std::int64_t depth_time_ns(std::uint64_t k) const override {
        return *time_ns(k) + (stamped_ ? is_earlier(k) ? -15 * ms : 14 * ms : 0);
    }
    Status read_luma(std::uint64_t k, ImageView<std::uint8_t> luma) override {
        copy_pixels(LumaView(images_.images[k]), luma);
        return ok();
    }
    Status read_depth(std::uint64_t k, ImageView<std::uint16_t> depth) override {
        copy_pixels(truth(k), depth);
        return ok();
    }
    DepthView truth(std::uint64_t k) const {
        return is_earlier(k) ? earlier_.depth[k] : later_.depth[k];
    }

private:
    static bool is_earlier(std::uint64_t k) { return k % 3 == 2; }
    static Film look(double late_s) {
        const SyntheticOptions options{.width = 160, .height = 120, .noise = false};
        SyntheticWorld world = make_world(options);
        world.camera = [late_s](double t) {
            const double y = 0.4 * std::sin(2 * std::numbers::pi * 0.7 * (t + late_s));
            return Pose{Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                        Eigen::Vector3d::Zero()};
        };
        return film(options, std::move(world), frames);
    }

    bool stamped_;
    Film images_, later_, earlier_;
};

/// Mean MRE, percent, of what is estimated, each measured against the map of its image.
double mre_of_uneven_pairs(bool stamped) {
    auto sequence = std::make_unique<UnevenPairs>(stamped);
    const UnevenPairs &played = *sequence;
    Rig rig = make_rig(std::move(sequence), {.real_time = false});
    WorkerPool pool(1);
    FrameLoop loop(rig, pipeline_factory({}, pool),
                   {.mode = GateMode::interval, .interval_frames = 7});
    REQUIRE(loop.start());
    double sum = 0;
    int count = 0;
    for (int k = 0; k < UnevenPairs::frames; ++k) {
        const FrameResult result = loop.step(std::chrono::nanoseconds(0));
        REQUIRE(result.capture == Capture::frame);
        if (result.estimate.source != FrameSource::estimated)
            continue;
        sum += compare_depth(result.estimate.depth, played.truth(result.sequence)).mre;
        ++count;
    }
    REQUIRE(count > 60);
    return sum / count;
}

} // namespace

TEST_CASE(
    "an estimate of registered depth is for the time at which the map of its image is exposed",
    "[core]") {
    const double with = mre_of_uneven_pairs(true), without = mre_of_uneven_pairs(false);
    CAPTURE(with, without);
    CHECK(with < 0.6 * without);
}

namespace {

using Microseconds = std::vector<long>;

struct Lags {
    Microseconds expected, measured;
};

/// Notes the lags that it is told.
struct Noted final : Pipeline {
    explicit Noted(Lags &told) : lags(told) {}
    const Estimate &track(LumaView /*luma*/, std::int64_t /*t_ns*/) override {
        lags.expected.push_back(std::lround(1e6 * lag_s));
        return estimate;
    }
    void expect_lag(double seconds) override { lag_s = seconds; }
    const Estimate &measure(const Measurement &measurement) override {
        lags.measured.push_back(std::lround(1e6 * measurement.lag_s));
        return estimate;
    }
    void restart() override {}
    Lags &lags;
    double lag_s = 0;
    Estimate estimate;
};

/// What a pipeline is told of three measured images, whose maps are exposed 9 ms later, 10 ms
/// earlier and 9 ms later than they. `known`: the TOF camera tells its times of exposure.
Lags lags_told(bool registered, bool known) {
    FakeCameras cameras;
    const auto late_ns = [&] { return cameras.sequence % 2 == 1 ? 9 * ms : -10 * ms; };
    cameras.read_tof = [&](DepthFrame &frame) {
        cameras.give_depth(frame);
        frame.t_ns += late_ns();
        return Capture::frame;
    };
    cameras.read_color = [&](ColorFrame &frame) {
        cameras.give_image(frame);
        if (known)
            cameras.exposes_ns = frame.t_ns + late_ns();
        return Capture::frame;
    };
    Rig rig = cameras.rig();
    const CameraModel camera{.pinhole = cameras.camera};
    const RigCalibration calibration{.color = camera, .tof = camera};
    const RigGeometry geometry =
        registered ? RigGeometry(cameras.camera) : RigGeometry(calibration, camera, {});
    Lags lags;
    FrameLoop loop(
        rig, [&](const RigGeometry &) { return std::make_unique<Noted>(lags); },
        {.mode = GateMode::always_on}, geometry);
    REQUIRE(loop.start());
    for (int k = 0; k < 3; ++k)
        REQUIRE(loop.step(std::chrono::nanoseconds(0)).tof == Capture::frame);
    return lags;
}

} // namespace

TEST_CASE(
    "an unmeasured image has the lag that the TOF camera tells, or else the last measured one") {
    const Lags unknown = lags_told(false, false), known = lags_told(false, true);
    CHECK(unknown.expected == Microseconds{0, 9'000, -10'000});
    CHECK(unknown.measured == Microseconds{9'000, -10'000, 9'000});
    CHECK(known.expected == Microseconds{9'000, -10'000, 9'000});
    CHECK(known.measured == known.expected);
}

TEST_CASE(
    "stamps of registered depth are used only if the TOF camera tells its times of exposure") {
    const Lags unknown = lags_told(true, false), known = lags_told(true, true);
    CHECK(unknown.expected == Microseconds{0, 0, 0});
    CHECK(unknown.measured == Microseconds{0, 0, 0});
    CHECK(known.expected == Microseconds{0, -19'000, 0});
    CHECK(known.measured == known.expected);
}
