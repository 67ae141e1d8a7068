// SPDX-License-Identifier: Apache-2.0
#include "capture/frame_loop.hpp"
#include "core/rig/rig_pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

/// A wide colour camera, and a small TOF camera 25 mm beside it that looks a little elsewhere.
RigCalibration two_cameras() {
    return {.color = {.pinhole = {300, 300, 321, 178, 640, 360},
                      .lens = Lens::kannala_brandt,
                      .distortion = {-0.02, 0.003, -0.001, 0.0002}},
            .tof = {.pinhole = {186, 188, 110, 87, 224, 172},
                    .lens = Lens::brown_conrady,
                    .distortion = {-0.25, 0.07, 0.001, -0.0008, 0.004}},
            .tof_from_color = {rotation({0.01, -0.02, 0.015}), {-0.025, 0.002, 0.001}},
            .range_along_ray = true};
}

RigGeometry publishing_color() {
    const RigCalibration rig = two_cameras();
    return {rig, rig.color, {}};
}
RigGeometry publishing_tof() {
    const RigCalibration rig = two_cameras();
    return {rig, rig.tof, rig.tof_from_color};
}
RigGeometry publishing_own() {
    return {two_cameras(), {.pinhole = {260, 260, 159.5, 119.5, 320, 240}}, {}};
}

struct Outcome {
    std::vector<double> mre; ///< of each frame, percent
    double coverage = 0;     ///< mean, percent
    int measured = 0, frames = 0;
    int measured_unlike_readings = 0; ///< pixels of measured frames
};

DepthMap copy_of(DepthView view) {
    DepthMap map(view.width(), view.height());
    for (int v = 0; v < view.height(); ++v)
        std::copy_n(view.row(v), view.width(), map.row(v));
    return map;
}

Outcome run(const RigGeometry &geometry, int frames, bool noise, int workers = 1,
            std::vector<DepthMap> *maps = nullptr) {
    const SyntheticOptions options{
        .real_time = false, .frames = frames, .noise = noise, .rig = geometry.rig};
    Result<Rig> rig = open_synthetic(options);
    REQUIRE(rig);
    SyntheticTruth truth(options);
    WorkerPool pool(workers);
    FrameLoop loop(*rig, pipeline_factory({}, pool), {}, geometry);
    REQUIRE(loop.start());
    Outcome outcome;
    for (FrameResult result = loop.step(0ns); result.capture == Capture::frame;
         result = loop.step(0ns)) {
        ++outcome.frames;
        const DepthView shown = result.estimate.depth;
        const DepthMap expected =
            truth.depth(result.sequence, geometry.published, geometry.published_from_color);
        REQUIRE(shown.width() == expected.width());
        REQUIRE(shown.height() == expected.height());
        double sum = 0;
        int count = 0;
        for (int v = 0; v < shown.height(); ++v)
            for (int u = 0; u < shown.width(); ++u)
                if (shown(u, v) != 0 && expected(u, v) != 0) {
                    sum += std::abs(shown(u, v) - expected(u, v)) /
                           static_cast<double>(expected(u, v));
                    ++count;
                }
        REQUIRE(count > 0);
        outcome.mre.push_back(100 * sum / count);
        outcome.coverage += result.estimate.coverage / frames;
        if (result.estimate.source == FrameSource::measured) {
            ++outcome.measured;
            for (int v = 0; v < shown.height(); ++v)
                for (int u = 0; u < shown.width(); ++u)
                    outcome.measured_unlike_readings +=
                        result.estimate.confidence(u, v) == measured_confidence &&
                        std::abs(shown(u, v) - expected(u, v)) > 1;
        }
        if (maps)
            maps->push_back(copy_of(shown));
    }
    return outcome;
}

/// Whether the TOF camera sees the point, and not at the rim of its picture.
bool is_measured(const RigCalibration &rig, const Eigen::Vector3d &in_color_frame) {
    constexpr double rim = 3;
    const Eigen::Vector2d at = rig.tof.project(rig.tof_from_color * in_color_frame);
    return at.x() >= rim && at.y() >= rim && at.x() <= rig.tof.pinhole.width - 1 - rim &&
           at.y() <= rig.tof.pinhole.height - 1 - rim;
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

} // namespace

TEST_CASE("two cameras with lenses give depth in the view of either, or of a third") {
    struct Case {
        const char *published;
        RigGeometry geometry;
        double least_coverage; ///< percent: the TOF camera sees a part of the view only
    };
    for (const Case &c : {Case{"color", publishing_color(), 35}, Case{"tof", publishing_tof(), 80},
                          Case{"own", publishing_own(), 85}}) {
        INFO("published: " << c.published);
        const Outcome outcome = run(c.geometry, 20, true);
        CHECK(outcome.frames == 20);
        CHECK(outcome.measured >= 1);
        CHECK(outcome.measured <= 4);
        CHECK(median(outcome.mre) < 0.4);
        CHECK(outcome.coverage > c.least_coverage);
    }
}

TEST_CASE("a rig's pipeline leaves out depth maps that nobody wants") {
    const RigGeometry geometry = publishing_tof();
    const SyntheticOptions options{.real_time = false, .frames = 6, .rig = geometry.rig};
    Result<Rig> rig = open_synthetic(options);
    REQUIRE(rig);
    WorkerPool pool(1);
    FrameLoop loop(*rig, pipeline_factory({}, pool), {}, geometry);
    loop.want_depth_every(1s);
    REQUIRE(loop.start());
    loop.step(0ns);
    const float coverage = loop.step(0ns).estimate.coverage; // after a measurement there is one
    CHECK(coverage > 80);
    loop.gate().set_policy({.mode = GateMode::off});
    const FrameResult skipped = loop.step(0ns);
    CHECK(skipped.estimate.depth.empty());
    CHECK(skipped.estimate.tracked);
    CHECK(skipped.estimate.coverage == coverage);
    loop.gate().set_policy({});
    loop.gate().request_measurement();
    const FrameResult measured = loop.step(0ns);
    CHECK(measured.estimate.source == FrameSource::measured);
    CHECK(measured.estimate.coverage > 80);
}

TEST_CASE("a program that used the TOF camera gets its readings as they were measured") {
    const Outcome outcome = run(publishing_tof(), 4, false);
    CHECK(outcome.measured >= 1);
    CHECK(outcome.measured_unlike_readings == 0);
}

TEST_CASE("single readings of the published TOF camera count in the coverage") {
    const RigGeometry geometry = publishing_tof();
    WorkerPool pool(1);
    const auto pipeline = pipeline_factory({}, pool)(geometry);
    const Intrinsics &color = geometry.rig.color.pinhole, &tof = geometry.rig.tof.pinhole;
    DepthMap depth(tof.width, tof.height, std::uint16_t{1500});
    for (int v = 40; v < 140; ++v)
        for (int u = 40; u < 180; ++u)
            if (u % 6 != 0 || v % 6 != 0)
                depth(u, v) = 0;
    pipeline->track(Luma(color.width, color.height, std::uint8_t{90}), 0);
    const Estimate &measured = pipeline->measure(depth);
    const DepthMap shown = copy_of(measured.depth);
    CHECK(shown(60, 60) != 0);
    const auto covered = std::ranges::count_if(shown.pixels(), [](auto mm) { return mm != 0; });
    CHECK(measured.coverage == Approx(100.0 * static_cast<double>(covered) /
                                      static_cast<double>(tof.width * tof.height)));
}

TEST_CASE("depth of two cameras does not depend on the number of workers") {
    std::vector<DepthMap> one, three;
    run(publishing_color(), 6, true, 1, &one);
    run(publishing_color(), 6, true, 3, &three);
    CHECK(one == three);
}

TEST_CASE("a small depth map in a large view has no holes inside a surface") {
    RigCalibration rig = two_cameras();
    rig.color.pinhole = {900, 900, 963, 534, 1920, 1080};
    const SyntheticOptions options{.real_time = false, .frames = 2, .noise = false, .rig = rig};
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = TofNoise::none()};
    const int body = world.scene.add_body(at_rest());
    world.scene.add_wall(body, 2, 100, world.scene.add_texture(make_texture(Pattern::print, 1)));
    Result<Rig> cameras = open_synthetic(options, world);
    REQUIRE(cameras);
    WorkerPool pool(1);
    FrameLoop loop(*cameras, pipeline_factory({}, pool), {}, RigGeometry(rig, rig.color, {}));
    REQUIRE(loop.start());
    for (int k = 0; k < 2; ++k) {
        const FrameResult result = loop.step(0ns);
        REQUIRE(result.estimate.source != FrameSource::none);
        const DepthView depth = result.estimate.depth;
        int inside = 0, wrong = 0;
        for (int v = 0; v < depth.height(); ++v)
            for (int u = 0; u < depth.width(); ++u) {
                const auto ray = rig.color.ray(u, v);
                if (!ray || !is_measured(rig, 2 * ray->homogeneous()))
                    continue;
                ++inside;
                wrong += std::abs(depth(u, v) - 2000) > 8;
            }
        CHECK(inside > 400'000);
        CHECK(wrong == 0);
    }
}

TEST_CASE("a rig's pipeline allocates nothing after it was made") {
    const RigGeometry geometry = publishing_color();
    const SyntheticOptions options{.real_time = false, .frames = 3, .rig = geometry.rig};
    Result<Rig> rig = open_synthetic(options);
    REQUIRE(rig);
    REQUIRE(rig->color->start());
    REQUIRE(rig->tof->start());
    REQUIRE(rig->illuminator->set(true));
    ColorFrame color{.luma = Luma(640, 360)};
    DepthFrame depth{.depth = DepthMap(224, 172), .amplitude = {}};
    WorkerPool pool(1);
    RigPipeline pipeline({}, geometry, pool);
    for (int k = 0; k < 3; ++k) {
        REQUIRE(rig->color->read(color, 0ns) == Capture::frame);
        REQUIRE(rig->tof->read(depth, 0ns) == Capture::frame);
        const std::uint64_t allocations = allocation_count();
        pipeline.track(color.luma, color.t_ns);
        pipeline.measure(depth.depth);
        if (k > 0)
            CHECK(allocation_count() == allocations);
    }
}

TEST_CASE("what a box hides from the colour camera is not shown through the box") {
    // A box before a wall, seen by a TOF camera 80 mm to the right of the colour camera.
    RigCalibration rig = two_cameras();
    rig.range_along_ray = false;
    rig.tof_from_color = {Eigen::Matrix3d::Identity(), {-0.08, 0, 0}};
    const RigGeometry geometry(rig, rig.color, {});
    SyntheticWorld world{.scene = {}, .camera = at_rest(), .tof = TofNoise::none()};
    const int body = world.scene.add_body(at_rest());
    const int texture = world.scene.add_texture(make_texture(Pattern::print, 1));
    world.scene.add_wall(body, 3, 100, texture);
    world.scene.add_box(body, {0, 0, 1.1}, {0.4, 0.4, 0.2}, texture);
    const SyntheticOptions options{.real_time = false, .frames = 1, .noise = false, .rig = rig};
    Result<Rig> cameras = open_synthetic(options, world);
    REQUIRE(cameras);
    SyntheticTruth truth(options, world);
    WorkerPool pool(1);
    FrameLoop loop(*cameras, pipeline_factory({}, pool), {}, geometry);
    REQUIRE(loop.start());
    const FrameResult result = loop.step(0ns);
    const DepthMap seen = truth.depth(0, geometry.published, {});
    int wall_shown_on_box = 0, compared = 0;
    for (int v = 0; v < seen.height(); ++v)
        for (int u = 0; u < seen.width(); ++u)
            if (result.estimate.depth(u, v) != 0) {
                ++compared;
                wall_shown_on_box +=
                    result.estimate.depth(u, v) > 2000 && seen(u, v) > 0 && seen(u, v) < 1500;
            }
    CHECK(compared > 40000);
    // At most a pixel along the box's outline, 0.4 m high and wide, 1 m away.
    CHECK(wall_shown_on_box < 4 * 0.4 * geometry.published.pinhole.fx);
}
