// SPDX-License-Identifier: Apache-2.0
#include "core/error/confidence_kernels.hpp"
#include "core/keyframe/depth_composer.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

/// The map of a room, drawn by a composer.
struct Drawn {
    Drawn()
        : film(film_room(200, 150, 1)), pool(2), composer(Views(film.camera), options, pool),
          keyframes(2, Views(film.camera), options.surface, options.alignment_template) {
        Keyframe &keyframe = keyframes.push(Pose::identity());
        keyframe.surface.build(film.depth[0], pool);
        alignment.covariance.diagonal().setConstant(1e-6f);
    }
    void compose(const Pose &now, const Twist &rate = Twist::Zero()) {
        composer.compose(keyframes, 0, now, alignment, rate,
                         film.camera.width * film.camera.height);
    }
    /// A shift that moves what is 2 m ahead by so many pixels.
    Pose shifted(double px) const {
        return {Eigen::Matrix3d::Identity(), {2 * px / film.camera.fx, 0, 0}};
    }

    Film film;
    KeyframeOptions options;
    WorkerPool pool;
    DepthComposer composer;
    KeyframeSet keyframes;
    Alignment alignment;
};

} // namespace

TEST_CASE("a composed map's confidence follows from each pixel's depth and distance from edges",
          "[core]") {
    Drawn drawn;
    const Pose now = drawn.shifted(9);
    drawn.compose(now);
    constexpr ErrorScales scales{.fresh = 1.3f, .carried = 0.8f};
    drawn.composer.judge({.scales = scales});

    const Keyframe &keyframe = drawn.keyframes[0];
    const Intrinsics &camera = drawn.film.camera;
    Warp warp(camera, camera, drawn.options.warp, drawn.pool);
    DepthMap depth(camera.width, camera.height);
    Image<std::uint8_t> edges(depth.width(), depth.height());
    const int covered = warp.run(keyframe.surface, now, depth, edges);
    const MapError error = map_error(keyframe.surface, Views(camera), now,
                                     drawn.alignment.covariance, drawn.options.error);
    CHECK(drawn.composer.depth() == depth);
    CHECK(drawn.composer.covered() == covered);
    const float share = uncorrelated_share(mean_displacement(keyframe.surface, camera, now));
    CHECK(drawn.composer.uncorrelated() == share);
    REQUIRE(share < 0.9f);
    double sum = 0, independent = 0; // over every eighth row
    int summed = 0;
    int other = 0; // by rounding
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u) {
            const auto error_at = [&](float z, float seen) {
                return pixel_error(error, keyframe.surface.noise(),
                                   drawn.options.error.shared_noise, z, edges(u, v))
                    .scaled({.fresh = seen * scales.fresh, .carried = scales.carried});
            };
            CAPTURE(u, v);
            std::uint8_t expected = no_confidence;
            if (edges(u, v) != 0) {
                const float z = middle_of_bin(depth_bin(depth(u, v)));
                expected = estimated_confidence(error_at(z, share));
                if (v % 8 == 0) {
                    sum += expected_error(expected);
                    independent += expected_error(estimated_confidence(error_at(z, 1)));
                    ++summed;
                }
                const float own = error_at(0.001f * static_cast<float>(depth(u, v)), share);
                REQUIRE(std::abs(expected_error(expected) - own) < 0.2f * own + confidence_step);
            }
            REQUIRE(std::abs(drawn.composer.confidence()(u, v) - expected) <= 1);
            REQUIRE((drawn.composer.confidence()(u, v) == 0) == (expected == 0));
            other += drawn.composer.confidence()(u, v) != expected;
        }
    CHECK(other < covered / 1000);
    CHECK(drawn.composer.expected_mre() == Approx(100 * sum / summed).epsilon(1e-3));
    CHECK(drawn.composer.independent_mre() == Approx(100 * independent / summed).epsilon(1e-3));
    drawn.composer.overlay(drawn.film.depth[0]);
    CHECK(drawn.composer.independent_mre() == drawn.composer.expected_mre());
    CHECK(drawn.composer.uncorrelated() == 1.0f);
}

TEST_CASE("a composed map's confidence is lowered only in cells where measurements found errors",
          "[core]") {
    Drawn drawn;
    drawn.compose(drawn.shifted(9));
    drawn.composer.judge({});
    const Image<std::uint8_t> before = drawn.composer.confidence();
    const float mre = drawn.composer.expected_mre();

    LocalErrors local(drawn.film.camera);
    Image<ComparedErrors> compared(MotionMask::cells(drawn.film.camera.width),
                                   MotionMask::cells(drawn.film.camera.height));
    local.predict(drawn.composer.depth(), Pose::identity(), 1);
    compared(2, 1) = {.true_sum = 100, .expected_sum = 0, .pixels = 1000};
    local.learn(compared, 1);
    local.predict(drawn.composer.depth(), Pose::identity(), 1);
    const float added = local.expected()(2, 1);
    REQUIRE(added > 0.01f);
    drawn.composer.judge({.local = &local});
    for (int v = 0; v < before.height(); ++v)
        for (int u = 0; u < before.width(); ++u) {
            const bool inside =
                u / MotionMask::cell_px == 2 && v / MotionMask::cell_px == 1 && before(u, v) != 0;
            const std::uint8_t expected =
                inside ? estimated_confidence(expected_error(before(u, v)) + added) : before(u, v);
            CAPTURE(u, v);
            REQUIRE(int{drawn.composer.confidence()(u, v)} == int{expected});
        }
    CHECK(drawn.composer.expected_mre() > mre);
}

TEST_CASE("the expected error of a map grows with the turning rates at the keyframe and now",
          "[core]") {
    const auto expected_mre = [](const Twist &then, const Twist &now) {
        Drawn drawn;
        drawn.keyframes[0].rate = then;
        drawn.compose(drawn.shifted(9), now);
        drawn.composer.judge({});
        return drawn.composer.expected_mre();
    };
    const Twist turning = 3 * Twist::Unit(4), slowly = 0.3 * turning;
    const float at_rest = expected_mre(Twist::Zero(), Twist::Zero());
    CHECK(expected_mre(Twist::Zero(), slowly) > at_rest);
    CHECK(expected_mre(Twist::Zero(), turning) > expected_mre(Twist::Zero(), slowly));
    CHECK(expected_mre(turning, Twist::Zero()) > expected_mre(slowly, Twist::Zero()));
    CHECK(expected_mre(turning, turning) > expected_mre(turning, Twist::Zero()));
}

TEST_CASE("a map that stays gets the confidences that a new one would get", "[core]") {
    Drawn kept, anew;
    kept.compose(kept.shifted(9));
    kept.composer.judge({});
    kept.compose(kept.shifted(9));
    REQUIRE_FALSE(kept.composer.drawn_anew());

    LocalErrors local(kept.film.camera);
    Image<ComparedErrors> compared(MotionMask::cells(kept.film.camera.width),
                                   MotionMask::cells(kept.film.camera.height));
    for (const int frames : {1, 2, 30}) {
        local.predict(kept.composer.depth(), Pose::identity(), frames);
        compared(2, 1) = {.true_sum = 50, .expected_sum = 0, .pixels = 1000};
        compared(3, 3) = {.true_sum = 20, .expected_sum = 0, .pixels = 1000};
        local.learn(compared, 1);
        local.predict(kept.composer.depth(), Pose::identity(), frames);
        const ErrorScales scales{.carried = frames < 30 ? 1 : 1.5f};
        kept.composer.judge({.scales = scales, .local = &local});
        anew.compose(anew.shifted(frames % 2 == 0 ? 40 : 20)); // so that the next is drawn
        anew.compose(anew.shifted(9));
        REQUIRE(anew.composer.drawn_anew());
        anew.composer.judge({.scales = scales, .local = &local});
        CAPTURE(frames);
        CHECK(kept.composer.confidence() == anew.composer.confidence());
        CHECK(kept.composer.expected_mre() == anew.composer.expected_mre());
        CHECK(kept.composer.independent_mre() == anew.composer.independent_mre());
    }
}

TEST_CASE("a composed map is kept while the camera rests and drawn anew when it moves", "[core]") {
    Drawn drawn;
    drawn.compose(drawn.shifted(3));
    CHECK(drawn.composer.drawn_anew());
    const DepthMap first = drawn.composer.depth();

    drawn.compose(drawn.shifted(3.02));
    CHECK_FALSE(drawn.composer.drawn_anew());
    CHECK(drawn.composer.depth() == first);
    drawn.compose(drawn.shifted(3.5));
    CHECK(drawn.composer.drawn_anew());
    CHECK(drawn.composer.depth() != first);

    SECTION("by small steps") {
        int anew = 0;
        for (int k = 0; k < 50; ++k) {
            drawn.compose(drawn.shifted(3.5 + 0.02 * k)); // a pixel in all
            anew += drawn.composer.drawn_anew();
        }
        CHECK(anew > 5);
        CHECK(anew < 40);
    }
    SECTION("along the axis, where no pixel in the middle moves") {
        Pose nearer = drawn.shifted(3.5);
        nearer.T.z() -= 0.01;
        drawn.compose(nearer);
        CHECK(drawn.composer.drawn_anew());
    }
    SECTION("when a measured map was laid over it") {
        drawn.composer.overlay(drawn.film.depth[0]);
        drawn.compose(drawn.shifted(3.5));
        CHECK(drawn.composer.drawn_anew());
        CHECK(drawn.composer.depth() != drawn.film.depth[0]);
    }
    SECTION("when it was emptied") {
        drawn.composer.clear();
        drawn.compose(drawn.shifted(3.5));
        CHECK(drawn.composer.drawn_anew());
        CHECK(drawn.composer.covered() > 0);
    }
    SECTION("of another keyframe") {
        Keyframe &newest = drawn.keyframes.push(Pose::identity());
        newest.surface.build(drawn.film.depth[0], drawn.pool);
        newest.t_ns = 1;
        drawn.compose(drawn.shifted(3.5));
        CHECK(drawn.composer.drawn_anew());
    }
}

TEST_CASE("displacing parts of a composed map moves depths and confidences and leaves the drawn "
          "map as it was",
          "[core]") {
    Drawn drawn;
    const Intrinsics &camera = drawn.film.camera;
    const Views views(camera);
    constexpr int most_level = 3;
    ResidualFlow flow(views, most_level);
    const Luma &then = drawn.film.images[0];
    Image<std::uint8_t> moving(MotionMask::cells(camera.width), MotionMask::cells(camera.height));
    const auto move = [&](int right, int down) { // all of the picture, and out of it
        Luma now = then;
        for (int v = 0; v < then.height(); ++v)
            for (int u = 0; u < then.width(); ++u)
                now(u, v) = then(std::clamp(u - right, 0, then.width() - 1),
                                 std::clamp(v - down, 0, then.height() - 1));
        Pyramid reference(camera.width, camera.height, most_level);
        reference.build(then);
        Pyramid image(camera.width, camera.height, most_level);
        image.build(now);
        flow.find({reference.level(flow.level()), 1}, image, {}, drawn.composer.drawn(), moving);
    };
    const auto displaced = [&](const auto &map) {
        auto expected = map;
        for (int v = 0; v < flow.shifts().height() << flow.level(); ++v)
            for (int u = 0; u < flow.shifts().width() << flow.level(); ++u) {
                const ResidualFlow::Shift shift =
                    flow.shifts()(u >> flow.level(), v >> flow.level());
                const bool shown = map.view().contains(u + shift.u, v + shift.v);
                expected(u, v) = 0;
                if (shown)
                    expected(u, v) = map(u + shift.u, v + shift.v);
            }
        return expected;
    };
    const auto check = [&](const DepthMap &map, const Image<std::uint8_t> &confidence) {
        drawn.composer.displace(flow);
        CHECK(drawn.composer.depth() == displaced(map));
        drawn.composer.judge({});
        CHECK(drawn.composer.confidence() == displaced(confidence));
        const auto depths = drawn.composer.depth().pixels();
        CHECK(drawn.composer.covered() ==
              std::ranges::count_if(depths, [](std::uint16_t depth) { return depth != 0; }));
    };
    constexpr std::array<std::pair<int, int>, 4> moves = {{{6, 4}, {-7, -5}, {8, 0}, {0, -8}}};
    for (std::size_t first = 0; first < moves.size(); ++first) {
        CAPTURE(first);
        const Pose camera_now = drawn.shifted(first % 2 == 0 ? 9 : 20);
        drawn.compose(camera_now);
        REQUIRE(drawn.composer.drawn_anew());
        const DepthMap map = drawn.composer.depth();
        drawn.composer.judge({});
        const Image<std::uint8_t> confidence = drawn.composer.confidence();
        std::ranges::fill(moving.pixels(), std::uint8_t{0});
        moving(3, 2) = 1; // some cells, then all, while the map stays
        for (std::size_t k = 0; k < moves.size(); ++k) {
            const auto [right, down] = moves[(first + k) % moves.size()];
            CAPTURE(right, down);
            move(right, down);
            REQUIRE(flow.any());
            check(map, confidence);
            CHECK(drawn.composer.depth() != map);
            drawn.compose(camera_now);
            REQUIRE_FALSE(drawn.composer.drawn_anew());
            const DepthView kept = drawn.composer.drawn();
            CHECK(std::ranges::equal(map.pixels(), std::span(kept.data(), map.pixels().size())));
            std::ranges::fill(moving.pixels(), std::uint8_t{1});
        }
        move(0, 0);
        REQUIRE_FALSE(flow.any());
        check(map, confidence);
        CHECK(drawn.composer.depth() == map);
    }
}
