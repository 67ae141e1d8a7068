// SPDX-License-Identifier: Apache-2.0
//
// Depth edges against image edges: what is wrong with a calibration is said, and nothing else.
#include "core/calibration/calibration_guard.hpp"
#include "core/calibration/calibration_watch.hpp"
#include "core/pipeline.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/wrong_rig.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr int levels = 4;

/// A watch that is shown measurements of a rig, half a second apart.
class Watched {
public:
    Watched(const SyntheticOptions &options, const Miscalibration &wrong)
        : rig(options, wrong), surface_(rig.camera(), {}),
          image_(rig.camera().width, rig.camera().height, levels), watch(rig.camera(), levels) {}

    void measure(int times) {
        for (int i = 0; i < times; ++i, ++measurements_) {
            const double t_s = 0.5 * measurements_;
            rig.look(t_s, static_cast<std::uint64_t>(measurements_));
            surface_.build(rig.depth, pool_);
            image_.build(rig.luma);
            const std::uint64_t before = allocation_count();
            watch.add(surface_, rig.camera(), Pose::identity(), image_, rig.rate(t_s));
            const std::uint64_t after = allocation_count();
            CHECK(after == before);
        }
    }
    /// The names of what is suspect after so many measurements.
    std::vector<std::string> suspects_after(int times) {
        measure(times);
        std::vector<std::string> names;
        for (std::size_t i = 0; i < calibration_parts; ++i)
            if (watch.state().parts[i].suspect)
                names.emplace_back(to_string(static_cast<CalibrationPart>(i)));
        return names;
    }

    WrongRig rig;

private:
    WorkerPool pool_ = WorkerPool(1);
    DepthSurface surface_;
    Pyramid image_;
    int measurements_ = 0;

public:
    CalibrationWatch watch;
};

using Names = std::vector<std::string>;

Twist turned(double x, double y, double z) {
    return (Twist() << 0, 0, 0, x * degree, y * degree, z * degree).finished();
}
Twist moved(double x, double y, double z) {
    return (Twist() << x, y, z, 0, 0, 0).finished();
}

/// Mean distance, pixels of the image, between where a correction puts points of the TOF camera
/// and where they belong.
double misplaced(const Intrinsics &camera, const Pose &corrected, const Pose &truth, double focal) {
    double sum = 0;
    int count = 0;
    for (const double z : {1.0, 2.0, 4.0})
        for (int v = 40; v < camera.height; v += 80)
            for (int u = 40; u < camera.width; u += 80, ++count) {
                const Eigen::Vector3d assumed = camera.back_project(u, v, z);
                const Eigen::Vector3d real{assumed.x() / (1 - focal), assumed.y() / (1 - focal), z};
                sum += (camera.project(corrected * assumed) - camera.project(truth * real)).norm();
            }
    return sum / count;
}
double misplaced(const Watched &rig, const Pose &truth, double focal) {
    return misplaced(rig.rig.camera(), correction(rig.watch.suspected()), truth, focal);
}
double misplaced_as_calibrated(const Watched &rig, const Pose &truth, double focal) {
    return misplaced(rig.rig.camera(), {}, truth, focal);
}

} // namespace

TEST_CASE("a calibration that is right is not suspect, whether the camera moves or not", "[core]") {
    const auto [seed, motion] = GENERATE(table<std::uint64_t, double>({{1, 1}, {3, 1}, {2, 0}}));
    Watched rig({.seed = seed, .motion = motion}, {});
    CHECK(rig.suspects_after(10) == Names{});
    CHECK(rig.watch.shift() == 0.0f);
    CHECK(rig.watch.suspected().isZero(0));
}

TEST_CASE("a TOF camera that is turned by two degrees is suspect, by how much, and corrected",
          "[core]") {
    const auto [x, y, z, motion] = GENERATE(
        table<double, double, double, double>({{2, 0, 0, 1}, {0, -2, 0, 0}, {0, 0, 2, 1}}));
    const Twist wrong = turned(x, y, z);
    Watched rig({.seed = 2, .motion = motion}, {.color_from_tof = wrong});
    const Names suspects = rig.suspects_after(10); // a translation may be told beside it
    REQUIRE_FALSE(suspects.empty());
    CHECK(suspects.front() == "rotation");
    const CalibrationFinding found = rig.watch.state()[CalibrationPart::rotation];
    CHECK(found.amount == Approx(2 * degree).margin(0.3 * degree));
    const Pose truth = afterglow::exp(wrong);
    CHECK(misplaced(rig, truth, 0) < 0.25 * misplaced_as_calibrated(rig, truth, 0));
    CHECK(rig.watch.shift() > 3 * rig.watch.shift(rig.watch.suspected()));
}

TEST_CASE("a focal length that is wrong by three percent is suspect and corrected", "[core]") {
    const double focal = GENERATE(0.03, -0.03);
    Watched rig({.seed = 2, .motion = 1}, {.focal = focal});
    CHECK(rig.suspects_after(10) == Names{"focal-length"});
    CHECK(rig.watch.state()[CalibrationPart::focal_length].amount == Approx(focal).margin(0.008));
    CHECK(misplaced(rig, {}, focal) < 0.4 * misplaced_as_calibrated(rig, {}, focal));
}

// Seen from one distance a shift looks like a turn, and either will do.
TEST_CASE("a TOF camera that is ten millimetres off is suspect and corrected", "[core]") {
    const auto [x, y, z] = GENERATE(
        table<double, double, double>({{0.01, 0, 0}, {-0.01, 0, 0}, {0, -0.01, 0}, {0, 0, 0.01}}));
    Watched rig({.seed = 5, .motion = 1}, {.color_from_tof = moved(x, y, z)});
    CHECK_FALSE(rig.suspects_after(10).empty());
    const Pose truth = afterglow::exp(moved(x, y, z));
    CHECK(misplaced(rig, truth, 0) < 0.6 * misplaced_as_calibrated(rig, truth, 0));
}

TEST_CASE("depth that is exposed 30 ms early or late is suspect where the camera moves", "[core]") {
    const double lag_s = GENERATE(0.03, -0.03);
    Watched rig({.seed = 2, .motion = 1}, {.lag_s = lag_s});
    CHECK(rig.suspects_after(10) == Names{"lag"});
    CHECK(rig.watch.state()[CalibrationPart::lag].amount == Approx(lag_s).margin(0.008));
    CHECK(rig.watch.shift() > 2 * rig.watch.shift(rig.watch.suspected()));
}

TEST_CASE("a calibration is trusted again when images and depth agree again", "[core]") {
    const SyntheticOptions options{.seed = 2, .motion = 0};
    Watched wrong(options, {.color_from_tof = turned(0, 2, 0)});
    REQUIRE(wrong.suspects_after(10) == Names{"rotation"});
    WrongRig right(options, {});
    DepthSurface surface(right.camera(), {});
    Pyramid image(right.camera().width, right.camera().height, levels);
    WorkerPool pool(1);
    int needed = 0;
    for (; needed < 20 && wrong.watch.state().suspect(); ++needed) {
        right.look(0, static_cast<std::uint64_t>(needed));
        surface.build(right.depth, pool);
        image.build(right.luma);
        wrong.watch.add(surface, right.camera(), Pose::identity(), image, Twist::Zero());
    }
    CHECK(needed > 1); // one measurement does not make it well
    CHECK(needed < 20);
    CHECK(wrong.watch.shift() == 0.0f);
}

TEST_CASE("a surface that the calibration guard moves keeps its depth correction", "[core]") {
    WrongRig rig({.seed = 2, .motion = 0}, {.color_from_tof = turned(0, 2, 0)});
    Views views(rig.camera());
    views.calibrated = true;
    WorkerPool pool(1);
    CalibrationGuard guard(views, levels, {}, pool);
    DepthSurface surface(rig.camera(), {});
    Pyramid image(rig.camera().width, rig.camera().height, levels);
    const DepthCorrection correction{.shape = {0.02F, -0.01F, 0.01F}, .lag_s = 0.001};
    for (int i = 0; i < 10; ++i) {
        rig.look(0.5 * i, static_cast<std::uint64_t>(i));
        surface.build(rig.depth, pool, correction);
        image.build(rig.luma);
        guard.check(surface, CameraMotion(MotionOptions{}), 0, image);
    }
    REQUIRE(guard.state()[CalibrationPart::rotation].corrected > 0);
    CHECK(surface.correction().shape == correction.shape);
    CHECK(surface.correction().lag_s == correction.lag_s);
    DepthSurface plain(rig.camera(), {});
    plain.build(rig.depth, pool);
    guard.check(plain, CameraMotion(MotionOptions{}), 0, image);
    std::vector<float> differences;
    for (int v = 40; v < rig.camera().height - 40; v += 4)
        for (int u = 40; u < rig.camera().width - 40; u += 4)
            if (surface.z()(u, v) > 0 && plain.z()(u, v) > 0) {
                const Eigen::Vector3d ray = rig.camera().back_project(u, v, 1);
                const float once =
                    correction.scale(static_cast<float>(ray.x()), static_cast<float>(ray.y()));
                differences.push_back(std::abs(surface.z()(u, v) / plain.z()(u, v) - once));
            }
    REQUIRE(differences.size() > 1000);
    std::ranges::nth_element(differences, differences.begin() + differences.size() / 2);
    CHECK(differences[differences.size() / 2] < 0.001F);
}

TEST_CASE("what says nothing of the calibration changes nothing", "[core]") {
    const Intrinsics camera{525, 525, 319.5, 239.5, 640, 480};
    WorkerPool pool(1);
    DepthSurface surface(camera, {});
    Pyramid image(camera.width, camera.height, levels);
    CalibrationWatch watch(camera, levels);
    std::mt19937 random(1);
    DepthMap box(camera.width, camera.height, std::uint16_t{2000});
    for (int v = 120; v < 360; ++v)
        for (int u = 200; u < 440; ++u)
            box(u, v) = 1000;
    Luma noise(camera.width, camera.height);

    SECTION("maps without depth or without edges") {
        for (const int depth : {0, 1500}) {
            surface.build(DepthMap(camera.width, camera.height, static_cast<std::uint16_t>(depth)),
                          pool);
            image.build(noise);
            for (int i = 0; i < 4; ++i)
                watch.add(surface, camera, Pose::identity(), image, Twist::Zero());
        }
    }
    SECTION("images that are black") {
        surface.build(box, pool);
        image.build(noise);
        for (int i = 0; i < 6; ++i)
            watch.add(surface, camera, Pose::identity(), image, Twist::Zero());
    }
    SECTION("images that are noise") {
        surface.build(box, pool);
        for (int i = 0; i < 10; ++i) {
            for (std::uint8_t &pixel : noise.pixels())
                pixel = static_cast<std::uint8_t>(random());
            image.build(noise);
            watch.add(surface, camera, Pose::identity(), image, Twist::Zero());
        }
    }
    SECTION("a motion or a pose that is not a number") {
        surface.build(box, pool);
        image.build(noise);
        const double nan = std::numeric_limits<double>::quiet_NaN();
        Pose nowhere;
        nowhere.T.setConstant(nan);
        for (int i = 0; i < 6; ++i) {
            watch.add(surface, camera, Pose::identity(), image, Twist::Constant(nan));
            watch.add(surface, camera, nowhere, image, Twist::Zero());
            watch.add(surface, camera, Pose::identity(), image, Twist::Constant(1e30));
        }
    }
    CHECK_FALSE(watch.state().suspect());
    CHECK(watch.shift() == 0.0f);
    CHECK(watch.suspected().isZero(0));
}

TEST_CASE("the calibration is not judged by the camera's motion from before a pause",
          "[core][long]") {
    const Miscalibration late{.lag_s = 0.03};
    WrongRig moving({.seed = 2, .motion = 1}, late);
    WrongRig resting({.seed = 2, .motion = 0}, late);
    WorkerPool pool(1);
    const CameraModel camera{.pinhole = moving.camera()};
    const RigGeometry told({.color = camera, .tof = camera}, camera, Pose::identity());
    const auto pipeline = pipeline_factory({}, pool)(told);
    CalibrationState state;
    int k = 0;
    const auto see = [&](WrongRig &rig, bool measures) {
        rig.look(k / 30.0, static_cast<std::uint64_t>(k));
        pipeline->track(rig.luma, k * std::int64_t{33'333'333});
        if (measures)
            state = pipeline->measure(rig.depth).calibration;
        ++k;
    };
    for (int pair = 0; pair < 8; ++pair) {
        pipeline->restart();
        see(moving, true);
        for (int i = 1; i < 6; ++i)
            see(moving, false);
        see(moving, true);
        pipeline->restart();
        see(resting, true);
    }
    CHECK(state[CalibrationPart::lag].suspect);
    CHECK(state[CalibrationPart::lag].amount == Approx(0.03).margin(0.008));
}

TEST_CASE("after ten measurements a wrong calibration is told and its errors are expected",
          "[core][long]") {
    const auto [seed, wrong] =
        GENERATE(table<std::uint64_t, Miscalibration>({{2, {.color_from_tof = turned(0, 2, 0)}},
                                                       {2, {.color_from_tof = moved(0.01, 0, 0)}},
                                                       {4, {.color_from_tof = moved(0, -0.01, 0)}},
                                                       {4, {.focal = -0.03}},
                                                       {4, {.lag_s = -0.03}}}));
    CAPTURE(seed);
    WrongRig rig({.seed = seed, .motion = 1}, wrong);
    WorkerPool pool(1);
    const CameraModel camera{.pinhole = rig.camera()};
    const RigGeometry told({.color = camera, .tof = camera}, camera, Pose::identity());
    const auto pipeline = pipeline_factory({}, pool)(told);
    constexpr int interval = 6, learning = 10 * interval, frames = learning + 4 * interval;
    double true_sum = 0, expected_sum = 0;
    int worse = 0, estimates = 0;
    const auto corrected = [](const CalibrationState &state) {
        return std::ranges::any_of(state.parts,
                                   [](const auto &part) { return part.corrected != 0; });
    };
    bool corrects = false;
    for (int k = 0; k < frames; ++k) {
        const double t_s = k / 30.0;
        rig.look(t_s, static_cast<std::uint64_t>(k));
        const Estimate &estimate = pipeline->track(rig.luma, k * std::int64_t{33'333'333});
        if (k % interval == 0) {
            const CalibrationState &state = pipeline->measure(rig.depth).calibration;
            corrects = corrected(state);
            CHECK_FALSE((corrects && state[CalibrationPart::lag].suspect));
            continue;
        }
        if (k < learning)
            continue;
        double sum = 0;
        int count = 0;
        for (int v = 0; v < rig.camera().height; v += 2)
            for (int u = 0; u < rig.camera().width; u += 2) {
                const float z = rig.true_depth()(u, v);
                if (z == 0.0f || estimate.depth(u, v) == 0)
                    continue;
                sum += std::abs(0.001 * estimate.depth(u, v) / z - 1);
                ++count;
            }
        REQUIRE(count > 1000);
        CHECK(estimate.calibration.suspect());
        const double mre = 100 * sum / count;
        true_sum += mre;
        expected_sum += estimate.expected_mre;
        worse += mre > 1.5 * estimate.expected_mre;
        ++estimates;
    }
    CAPTURE(true_sum / estimates, expected_sum / estimates);
    CHECK(corrects == (wrong.lag_s == 0));
    CHECK(worse == 0);
    CHECK(true_sum < 1.5 * expected_sum);
}
