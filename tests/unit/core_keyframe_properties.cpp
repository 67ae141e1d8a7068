// SPDX-License-Identifier: Apache-2.0
//
// What must hold of preset "default" whatever is before the camera.
#include "eval/scoring/metrics.hpp"
#include "tests/allocation_count.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <cmath>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

constexpr int frames = 9;

/// What the last of `order` is estimated to be, when the first is measured and the others tracked.
struct Answer {
    Pose pose;
    DepthMap depth;
    float coverage;
};

Answer answer(const Film &film, const std::vector<int> &order) {
    Viewer viewer(film);
    viewer.track(order.front());
    viewer.measure(order.front());
    const Estimate *estimate = nullptr;
    for (std::size_t i = 1; i < order.size(); ++i)
        estimate = &viewer.track(order[i]);
    REQUIRE(estimate->source == FrameSource::estimated);
    return {estimate->pose, copy(estimate->depth), estimate->coverage};
}

std::vector<int> forwards() {
    std::vector<int> order;
    for (int k = 0; k < frames; ++k)
        order.push_back(k);
    return order;
}

/// One pose is the other, to a fraction of what the camera has moved.
void check_same(const Pose &a, const Pose &b) {
    const Pose between = a * b.inverse();
    CHECK(between.T.norm() < 0.003);
    CHECK(between.angle() < 0.0015);
}

void check_same(const Answer &a, const Answer &b) {
    check_same(a.pose, b.pose);
    CHECK(a.coverage == Approx(b.coverage).margin(1.0));
    CHECK(compare_depth(a.depth, b.depth).mre < 0.3);
}

const Film &room() {
    static const Film film = film_room(320, 240, frames, 2);
    return film;
}

} // namespace

TEST_CASE("the keyframe pipeline follows a hand-held camera", "[core]") {
    const Answer end = answer(room(), forwards());
    const DepthErrors errors = compare_depth(end.depth, room().depth.back());
    CHECK(errors.mre < 0.5);
    CHECK(errors.coverage() > 80);
    CHECK(end.pose.T.norm() > 0.02); // it has moved, so there was something to follow
}

TEST_CASE("whether the keyframe pipeline prepares for the next image changes no estimate",
          "[core]") {
    Viewer prepares(room()), does_not(room());
    for (int k = 0; k < frames; ++k) {
        const auto check_alike = [](const Estimate &a, const Estimate &b) {
            CHECK(copy(a.depth) == copy(b.depth));
            CHECK(a.world_from_camera.T == b.world_from_camera.T);
            CHECK(a.expected_mre == b.expected_mre);
        };
        CAPTURE(k);
        const Estimate &tracked = prepares.track(k);
        check_alike(tracked, does_not.track(k));
        prepares.prepare();
        if (k % 3 == 0) {
            const Estimate &measured = prepares.measure(k);
            const DepthMap published = copy(measured.depth);
            prepares.prepare();
            prepares.prepare();
            CHECK(copy(measured.depth) == published);
            check_alike(measured, does_not.measure(k));
        }
        if (k == 6) { // what is not prepared is forgotten with the rest
            prepares.restart();
            does_not.restart();
        }
    }
}

TEST_CASE("the keyframe pipeline is invariant to the world coordinate frame", "[core]") {
    const SyntheticOptions options{.width = 320, .height = 240, .noise = false, .motion = 2};
    SyntheticWorld moved = make_world(options);
    const Pose shift{rotation({0.4, -1.1, 0.3}), {3, -2, 5}};
    for (Motion &body : moved.scene.bodies)
        body = [body, shift](double t) { return shift * body(t); };
    moved.camera = [camera = moved.camera, shift](double t) { return shift * camera(t); };
    check_same(answer(film(options, std::move(moved), frames), forwards()),
               answer(room(), forwards()));
}

TEST_CASE("the keyframe pipeline mirrors its result for a mirrored scene", "[core]") {
    const Answer plain = answer(room(), forwards());
    const Answer seen = answer(mirrored(room()), forwards());
    const Eigen::Vector3d flip(-1, 1, 1);
    const Answer back{
        {flip.asDiagonal() * seen.pose.R * flip.asDiagonal(), flip.asDiagonal() * seen.pose.T},
        mirrored(seen.depth),
        seen.coverage};
    check_same(back, plain);
}

TEST_CASE("the keyframe pipeline scales its motion with the scene", "[core]") {
    Film larger = room();
    for (DepthMap &depth : larger.depth)
        for (std::uint16_t &z : depth.pixels())
            z = static_cast<std::uint16_t>(z * 3 / 2);
    Answer seen = answer(larger, forwards());
    seen.pose.T /= 1.5;
    check_same(seen.pose, answer(room(), forwards()).pose);
}

TEST_CASE("depth and expected error of the keyframe pipeline do not depend on whether "
          "confidences are wanted",
          "[core]") {
    const Film scene = film_room(320, 240, 14);
    Viewer always(scene), sometimes(scene);
    sometimes.want_confidence(false);
    for (int k = 0; k < 14; ++k) {
        const int shown = k / 2 * 2; // each image twice, so that some maps stay
        sometimes.want_confidence(k % 4 == 3);
        const Estimate &all = always.track(shown), &some = sometimes.track(shown);
        CAPTURE(k);
        CHECK(copy(some.depth) == copy(all.depth));
        CHECK(some.expected_mre == all.expected_mre);
        CHECK(some.independent_mre == all.independent_mre);
        CHECK(some.fresh_mre == all.fresh_mre);
        if (k % 4 == 3)
            CHECK(copy(some.confidence) == copy(all.confidence));
        else
            CHECK(some.confidence.empty());
        if (k == 0 || k == 8) {
            CHECK(copy(sometimes.measure(shown).confidence) ==
                  copy(always.measure(shown).confidence));
            CHECK(some.expected_mre == all.expected_mre);
        }
    }
}

TEST_CASE("leaving out unwanted depth maps changes no other map of the keyframe pipeline",
          "[core]") {
    const Film scene = film_room(320, 240, 14);
    Viewer always(scene), sometimes(scene);
    for (int k = 0; k < 14; ++k) {
        const bool wanted = k % 3 == 1;
        sometimes.want_depth(wanted);
        const Estimate &all = always.track(k), &some = sometimes.track(k);
        CAPTURE(k);
        CHECK(some.pose.T == all.pose.T);
        CHECK(some.pose.R == all.pose.R);
        CHECK(some.age_ns == all.age_ns);
        CHECK(some.tracked == all.tracked);
        if (wanted) {
            CHECK(copy(some.depth) == copy(all.depth));
            CHECK(copy(some.confidence) == copy(all.confidence));
            CHECK(some.expected_mre == all.expected_mre);
        } else if (k > 0) { // before the first measurement there is nothing to leave out
            CHECK(some.depth.empty());
            CHECK(some.confidence.empty());
        }
        if (k == 0 || k == 6 || k == 7) { // of images with and without a map
            const Estimate &measured = sometimes.measure(k);
            CHECK(copy(measured.depth) == copy(always.measure(k).depth));
            CHECK(measured.fresh_mre == all.fresh_mre);
        }
    }
}

TEST_CASE(
    "a keyframe pipeline that leaves out depth maps asks for light when it is lost, and finds "
    "the camera again",
    "[core]") {
    const Film scene = film_room(320, 240, 2);
    Viewer viewer(scene);
    viewer.track(0);
    viewer.measure(0);
    viewer.want_depth(false);
    viewer.track(1);
    const Estimate &lost = viewer.track(Luma(320, 240, std::uint8_t{128}));
    CHECK(lost.source == FrameSource::none);
    CHECK_FALSE(lost.tracked);
    CHECK(lost.wants_measurement);
    CHECK(lost.depth.empty());
    viewer.want_depth(true);
    const Estimate &found = viewer.track(1);
    CHECK(found.source == FrameSource::estimated);
    CHECK(found.coverage > 50);
}

TEST_CASE("the keyframe pipeline inverts the motion of a reversed sequence", "[core]") {
    std::vector<int> backwards = forwards();
    std::reverse(backwards.begin(), backwards.end());
    const Answer there = answer(room(), forwards());
    const Answer back = answer(room(), backwards);
    check_same(there.pose * back.pose, Pose::identity());
}

TEST_CASE("the keyframe pose is invariant to global brightness", "[core]") {
    Film brighter = room();
    for (std::size_t k = 1; k < brighter.images.size(); ++k)
        for (std::uint8_t &pixel : brighter.images[k].pixels())
            pixel = static_cast<std::uint8_t>(20 + pixel * 4 / 5);
    check_same(answer(brighter, forwards()).pose, answer(room(), forwards()).pose);
}

TEST_CASE(
    "the keyframe pipeline falls back to frame-to-frame motion when the keyframe no longer matches",
    "[core]") {
    // The light goes down to a sixth, more than any one alignment allows for.
    constexpr int last = 32;
    const Film lit = film_room(320, 240, last + 1, 1);
    Film dimmed = lit;
    for (std::size_t k = 0; k < dimmed.images.size(); ++k)
        for (std::uint8_t &pixel : dimmed.images[k].pixels())
            pixel = static_cast<std::uint8_t>(
                std::lround(pixel * std::pow(1.0 / 6, static_cast<double>(k) / last)));
    Viewer viewer(dimmed);
    Viewer by_day(lit);
    viewer.track(0);
    by_day.track(0);
    viewer.measure(0);
    by_day.measure(0);
    float expected = 0;
    for (int k = 1; k <= last; ++k) {
        const Estimate &estimate = viewer.track(k);
        CAPTURE(k);
        REQUIRE(estimate.source == FrameSource::estimated);
        CHECK(!estimate.wants_measurement);
        if (k == last / 2)
            expected = estimate.expected_mre;
        by_day.track(k);
    }
    const Estimate &estimate = viewer.track(last);
    const Pose apart = estimate.pose * by_day.track(last).pose.inverse();
    CHECK(apart.T.norm() < 0.03);
    CHECK(apart.angle() < 0.01);
    CHECK(compare_depth(estimate.depth, lit.depth.back()).mre < 1.0);
    CHECK(estimate.expected_mre > expected); // steps add up, and so does their error
}

TEST_CASE("the keyframe pipeline allocates nothing per frame", "[core]") {
    for (const int workers : {1, 3}) {
        Viewer viewer(room(), {}, workers);
        const std::uint64_t before = allocation_count();
        for (int k = 0; k < frames; ++k) {
            viewer.track(k);
            if (k % 3 == 0)
                viewer.measure(k);
        }
        CHECK(allocation_count() == before);
    }
}

TEST_CASE("the expected error approaches that of uncorrelated maps as the camera moves", "[core]") {
    Viewer viewer(room());
    viewer.track(0);
    CHECK(viewer.measure(0).independent_mre == viewer.measure(0).expected_mre);
    const auto share = [&](int k) {
        const Estimate &estimate = viewer.track(k);
        return estimate.expected_mre / estimate.independent_mre;
    };
    const float at_rest = share(0);
    CHECK(at_rest < 0.8f);
    for (int k = 2; k < frames; k += 2) {
        const float moved = share(k);
        CHECK(moved > at_rest + 0.1f);
        CHECK(moved < 1);
    }
}
