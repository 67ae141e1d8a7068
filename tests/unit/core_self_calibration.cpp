// SPDX-License-Identifier: Apache-2.0
//
// What a TOF camera's maps have in common that is wrong: learnt, and carried into the estimates.
#include "core/calibration/self_calibration.hpp"
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <numbers>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

/// So certain a pair that only its systematic error counts.
CalibrationEvidence pair_of(const Eigen::Vector4d &truth) {
    CalibrationEvidence evidence;
    evidence.H = 1e12 * Eigen::Matrix4d::Identity();
    evidence.g = evidence.H * truth;
    return evidence;
}

/// The room seen by a camera that looks to and fro, its depth maps exposed `lag_s` late and bent by
/// `shape`.
Film shaken(double lag_s, const Eigen::Vector3f &shape) {
    const SyntheticOptions options{.width = 160, .height = 120, .noise = false};
    const auto look = [&options](double late_s) {
        SyntheticWorld world = make_world(options);
        world.camera = [late_s](double t) {
            const double at = t + late_s;
            const double y = 0.25 * std::sin(2 * std::numbers::pi * 0.8 * at);
            const double x = 0.25 * std::sin(2 * std::numbers::pi * 0.6 * at);
            return Pose{(Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(x, Eigen::Vector3d::UnitX()))
                            .toRotationMatrix(),
                        Eigen::Vector3d::Zero()};
        };
        return film(options, std::move(world), 120);
    };
    Film seen = look(0);
    seen.depth = look(lag_s).depth;
    DepthCorrection calibration;
    calibration.shape = shape;
    for (DepthMap &depth : seen.depth)
        for (int v = 0; v < depth.height(); ++v)
            for (int u = 0; u < depth.width(); ++u) {
                const auto x = static_cast<float>((u - seen.camera.cx) / seen.camera.fx);
                const auto y = static_cast<float>((v - seen.camera.cy) / seen.camera.fy);
                depth(u, v) = static_cast<std::uint16_t>(
                    std::lround(static_cast<float>(depth(u, v)) / calibration.scale(x, y)));
            }
    return seen;
}

/// Mean MRE, percent, of the estimates of the second half, one frame in six being measured.
double mre_of(const Film &seen, const SelfCalibrationOptions &learnt) {
    EstimatorOptions options;
    options.keyframe.self_calibration = learnt;
    Viewer viewer(seen, options);
    double sum = 0;
    int count = 0;
    const int frames = static_cast<int>(seen.images.size());
    for (int k = 0; k < frames; ++k) {
        const Estimate &estimate = viewer.track(k);
        if (k % 6 == 0) {
            viewer.measure(k);
        } else if (2 * k > frames) {
            REQUIRE(estimate.source == FrameSource::estimated);
            sum += compare_depth(estimate.depth, seen.depth[static_cast<std::size_t>(k)]).mre;
            ++count;
        }
    }
    return sum / count;
}

constexpr SelfCalibrationOptions nothing_learnt{.tilt = 0, .curvature = 0, .lag_s = 0};

} // namespace

TEST_CASE("self-calibration finds the lag between depth maps and images", "[core]") {
    const double lag_s = GENERATE(-0.012, 0.012);
    const Film seen = shaken(lag_s, Eigen::Vector3f::Zero());
    const double without = mre_of(seen, nothing_learnt);
    const double with = mre_of(seen, {});
    CAPTURE(lag_s, without, with);
    CHECK(with < 0.75 * without);
}

TEST_CASE("self-calibration finds and inverts the tilt and curvature of depth", "[core]") {
    const auto shape = GENERATE(Eigen::Vector3f{0.05f, 0, 0}, Eigen::Vector3f{0, -0.05f, 0},
                                Eigen::Vector3f{0, 0, -0.08f});
    const Film seen = shaken(0, shape);
    const double without = mre_of(seen, nothing_learnt);
    const double with = mre_of(seen, {});
    CAPTURE(shape.transpose(), without, with);
    CHECK(with < 0.75 * without);
}

TEST_CASE("self-calibration does not degrade an ideal camera", "[core]") {
    const Film seen = shaken(0, Eigen::Vector3f::Zero());
    CHECK(mre_of(seen, {}) < 1.1 * mre_of(seen, nothing_learnt));
}

TEST_CASE("self-calibration converges only over many pairs of maps", "[core]") {
    const Eigen::Vector4d truth{0.02, -0.01, 0.03, 0.005};
    SelfCalibration learner(
        {.tilt = 0.03f, .curvature = 0.03f, .lag_s = 0.01f, .pair_error = 2, .lag_pair_error = 1});
    CHECK(learner.correction().lag_s == 0);
    learner.add(pair_of(truth));
    CHECK(learner.correction().shape.x() == Approx(truth[0] / 5)); // 1 / (1 + 2^2)
    CHECK(learner.correction().lag_s == Approx(truth[3] / 2));     // 1 / (1 + 1^2)
    for (int i = 0; i < 400; ++i)
        learner.add(pair_of(truth));
    CHECK(learner.correction().lag_s == Approx(truth[3]).epsilon(0.02));
    CHECK(learner.correction().shape.x() == Approx(truth[0]).epsilon(0.02));
    CHECK(learner.correction().shape.z() == Approx(truth[2]).epsilon(0.02));
}

TEST_CASE("self-calibration stays finite and within three sigma", "[core]") {
    SelfCalibration learner({.tilt = 0.03f, .curvature = 0, .lag_s = 0.01f});
    for (int i = 0; i < 1000; ++i)
        learner.add(pair_of({10, 0, 10, -10}));
    CHECK(learner.correction().shape.x() == Approx(0.09));
    CHECK(learner.correction().shape.z() == 0);
    CHECK(learner.correction().lag_s == Approx(-0.03));
    const double before = learner.correction().lag_s;
    CalibrationEvidence bad;
    bad.H(3, 3) = std::numeric_limits<double>::infinity();
    bad.g[0] = std::numeric_limits<double>::quiet_NaN();
    learner.add(bad);
    CHECK(learner.correction().lag_s == before);
}
