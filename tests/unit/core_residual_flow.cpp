// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe_pipeline.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <cmath>
#include <functional>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

const SyntheticOptions options{
    .width = 320, .height = 240, .fps = 30, .seed = 1, .real_time = false, .noise = false};

/// A printed wall 2.5 m ahead and a printed box 1.2 m ahead that moves by itself.
Film film_box(const std::function<Pose(double t_s)> &box, int frames,
              const std::function<Pose(double t_s)> &camera = at_rest()) {
    SyntheticWorld world{.scene = {}, .camera = camera, .tof = TofNoise::none()};
    const int wall = world.scene.add_texture(make_texture(Pattern::print, 1));
    const int print = world.scene.add_texture(make_texture(Pattern::print, 2));
    world.scene.add_wall(world.scene.add_body(at_rest()), 2.5, 20, wall);
    world.scene.add_box(world.scene.add_body(box), {0, 0, 1.4}, {0.5, 0.5, 0.4}, print);
    return film(options, std::move(world), frames);
}
Pose shifted(double right_m, double down_m = 0) {
    return {Eigen::Matrix3d::Identity(), {right_m, down_m, 0}};
}
/// Share of the pixels that have depth in both, and not the same, percent.
double wrong(DepthView shown, DepthView truth) {
    int differ = 0, both = 0;
    for (int v = 0; v < truth.height(); ++v)
        for (int u = 0; u < truth.width(); ++u) {
            if (shown(u, v) == 0 || truth(u, v) == 0)
                continue;
            ++both;
            differ += std::abs(shown(u, v) - truth(u, v)) > truth(u, v) / 10;
        }
    return 100.0 * differ / both;
}
int covered(DepthView map) {
    int count = 0;
    for (int v = 0; v < map.height(); ++v)
        for (int u = 0; u < map.width(); ++u)
            count += map(u, v) != 0;
    return count;
}

/// Share of the pixels of a cell that get their depth from nowhere.
double from_nowhere(const ResidualFlow &flow, int x, int y) {
    const int cell = MotionMask::cell_px >> flow.level();
    int count = 0;
    for (int v = y * cell; v < (y + 1) * cell; ++v)
        for (int u = x * cell; u < (x + 1) * cell; ++u)
            count += flow.shifts()(u, v) == ResidualFlow::Shift::nowhere();
    return static_cast<double>(count) / (cell * cell);
}

} // namespace

TEST_CASE("composed depth follows a box that moves by itself", "[core]") {
    constexpr int frames = 9;
    const double speed = GENERATE(0.5, -1.0); // m/s; 4 and 7 pixels a frame
    const bool moved_camera = GENERATE(false, true);
    CAPTURE(speed, moved_camera);
    const Film film =
        film_box([&](double t_s) { return shifted(speed * t_s, 0.3 * t_s); }, frames,
                 [&](double t_s) { return shifted(0, moved_camera ? -0.2 * t_s : 0); });
    Viewer viewer(film);
    viewer.track(0);
    viewer.measure(0);
    for (int k = 1; k < frames; ++k) {
        const Estimate &estimate = viewer.track(k);
        const auto i = static_cast<std::size_t>(k);
        CAPTURE(k);
        CHECK(estimate.coverage ==
              Approx(100.0 * covered(estimate.depth) / (options.width * options.height)));
        if (k < 3)
            continue; // few of the box's points are seen to move so soon
        // The wall that the box uncovers was never measured: a part of it shows the box's depth.
        if (!moved_camera)
            CHECK(wrong(estimate.depth, film.depth[i]) <
                  0.65 * wrong(film.depth[0], film.depth[i]));
        const int u = 160 + static_cast<int>(std::lround(film.camera.fx * speed * k / 30 / 1.2));
        const int v = 120 + static_cast<int>(std::lround(
                                film.camera.fy * 0.3 * k / 30 / 1.2 +
                                (moved_camera ? -film.camera.fy * 0.2 * k / 30 / 1.2 : 0)));
        CHECK(estimate.depth(u, v) == Approx(film.depth[i](u, v)).epsilon(0.02));
    }
}

TEST_CASE("a box that moved and came back is shown where it stands", "[core]") {
    const Film film = film_box(
        [](double t_s) { return shifted(0.6 * std::sin(std::min(t_s, 0.4) * 7.854)); }, 20);
    Viewer viewer(film); // right within 0.2 s, and back to where it was
    viewer.track(0);
    viewer.measure(0);
    double worst = 0;
    DepthMap end;
    for (int k = 1; k < 20; ++k) {
        end = copy(viewer.track(k).depth);
        if (k > 13)
            worst = std::max(worst, wrong(end, film.depth[static_cast<std::size_t>(k)]));
    }
    CHECK(worst < 1);
    CHECK(covered(end) > 0.95 * covered(film.depth[0]));
}

TEST_CASE("a rigid scene with occlusions is shown alike with and without residual flow", "[core]") {
    // A nearer box hides more of the wall from image to image.
    const Film film = film_box(at_rest(), 10, [](double t_s) { return shifted(0, -0.2 * t_s); });
    EstimatorOptions not_followed;
    not_followed.keyframe.compose.follow_moving = false;
    Viewer with(film), without(film, not_followed);
    for (Viewer *viewer : {&with, &without}) {
        viewer->track(0);
        viewer->measure(0);
    }
    for (int k = 1; k < 10; ++k) {
        CAPTURE(k);
        const DepthMap shown = copy(with.track(k).depth);
        CHECK(shown == copy(without.track(k).depth));
        CHECK(wrong(shown, film.depth[static_cast<std::size_t>(k)]) < 0.5);
    }
}

TEST_CASE("residual flow is found in moving cells, and forgotten with its keyframe", "[core]") {
    // The picture as a whole goes right, under a camera that is said to be at rest.
    const Film film = film_box(at_rest(), 2, [](double t_s) { return shifted(-1.0 * t_s); });
    const Views views(film.camera);
    constexpr int most_level = 3;
    ResidualFlow flow(views, most_level);
    Pyramid then(320, 240, most_level), now(320, 240, most_level);
    then.build(film.images[0]);
    now.build(film.images[1]);
    const KeyframeImage keyframe = {then.level(flow.level()), 1};
    Image<std::uint8_t> moving(MotionMask::cells(320), MotionMask::cells(240));

    flow.find(keyframe, now, {}, film.depth[0], moving);
    CHECK_FALSE(flow.any());
    CHECK_FALSE(flow.changed());

    moving(4, 3) = 1; // on the box: 320 pixels focal length or so, 1.2 m away, 1 / 30 m
    flow.find(keyframe, now, {}, film.depth[0], moving);
    REQUIRE(flow.any());
    CHECK(flow.changed());
    const int cell = MotionMask::cell_px >> flow.level();
    const double expected = -film.camera.fx / 30 / 1.2;
    CHECK(flow.shifts()(4 * cell + cell / 2, 3 * cell + cell / 2).u ==
          Approx(expected).margin(1.5));
    CHECK(flow.shifts()(4 * cell + cell / 2, 3 * cell + cell / 2).v == Approx(0).margin(1));
    CHECK(flow.shifts()(cell / 2, cell / 2) == ResidualFlow::Shift{}); // far from that cell

    SECTION("the same again changes nothing") {
        flow.find(keyframe, now, {}, film.depth[0], moving);
        flow.find(keyframe, now, {}, film.depth[0], moving);
        CHECK(flow.any());
        CHECK_FALSE(flow.changed());
    }
    SECTION("what is not seen to move any more is not displaced") {
        moving(4, 3) = 0;
        flow.find(keyframe, now, {}, film.depth[0], moving);
        CHECK_FALSE(flow.any());
        CHECK(flow.changed());
    }
    SECTION("what is back in its place is not displaced") {
        flow.find(keyframe, then, {}, film.depth[0], moving);
        CHECK_FALSE(flow.any());
        CHECK(flow.changed());
        CHECK(flow.shifts()(4 * cell + cell / 2, 3 * cell + cell / 2) == ResidualFlow::Shift{});
    }
    SECTION("another keyframe begins anew") {
        flow.find({now.level(flow.level()), 2}, now, {}, film.depth[0], moving);
        CHECK_FALSE(flow.any());
        CHECK(flow.changed());
    }
    SECTION("pixels that look like nothing in the keyframe get depth from nowhere") {
        const float brightness = GENERATE(1.0f, 0.15f);
        CAPTURE(brightness);
        const auto shown = [&](Luma image) {
            for (std::uint8_t &grey : image.pixels())
                grey = static_cast<std::uint8_t>(brightness * static_cast<float>(grey));
            return image;
        };
        then.build(shown(film.images[0]));
        Luma other(320, 240);
        for (int v = 0; v < 240; ++v)
            for (int u = 0; u < 320; ++u)
                other(u, v) = static_cast<std::uint8_t>((u * u / 7 + v * v / 5 + u * v / 9) % 251);
        now.build(shown(other));
        flow.find({then.level(flow.level()), 2, brightness}, now, {}, film.depth[0], moving);
        CHECK(from_nowhere(flow, 4, 3) > 0.7);
        CHECK(from_nowhere(flow, 0, 0) == 0);
    }
}

TEST_CASE("pixels of moving cells get no depth where residual flow is off or of another view",
          "[core]") {
    const Film film = film_box(at_rest(), 1);
    Views views(film.camera);
    const bool followed = GENERATE(false, true);
    if (followed) // but shown from elsewhere
        views.published_from_tracking.T.x() = 0.03;
    ResidualFlow flow(views, 3, followed);
    Pyramid image(320, 240, 3);
    image.build(film.images[0]);
    Image<std::uint8_t> moving(MotionMask::cells(320), MotionMask::cells(240));
    moving(2, 2) = 1;
    flow.find({image.level(flow.level()), 1}, image, {}, film.depth[0], moving);
    CHECK(flow.any());
    CHECK(flow.changed());
    CHECK(from_nowhere(flow, 2, 2) == 1);
    CHECK(from_nowhere(flow, 3, 2) == 0);
    flow.find({image.level(flow.level()), 1}, image, {}, film.depth[0], moving);
    CHECK(flow.any());
    CHECK_FALSE(flow.changed());
    moving(2, 2) = 0;
    flow.find({image.level(flow.level()), 1}, image, {}, film.depth[0], moving);
    CHECK_FALSE(flow.any());
    CHECK(flow.changed());
}

TEST_CASE("residual flow is found on the finest level with at most 200 columns", "[core]") {
    const auto level = [](int width, int most) {
        return ResidualFlow::level_for({1, 1, 0, 0, width, width / 2}, most);
    };
    CHECK(level(160, 4) == 1);
    CHECK(level(320, 4) == 1);
    CHECK(level(640, 4) == 2);
    CHECK(level(1280, 4) == 3);
    CHECK(level(1280, 2) == 2);
    CHECK(level(20000, 9) == 5);
    CHECK(level(16, 1) == 1);
}

TEST_CASE("a picture smaller than a patch has no residual flow", "[core]") {
    const Intrinsics camera{20, 20, 7.5, 5.5, 16, 12};
    ResidualFlow flow(Views(camera), 1);
    Pyramid image(16, 12, 1);
    image.build(Luma(16, 12, 50));
    Image<std::uint8_t> moving(1, 1, 1);
    flow.find({image.level(1), 1}, image, {}, DepthMap(16, 12, 1000), moving);
    CHECK_FALSE(flow.any());
}
