// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/direct_alignment.hpp"
#include "core/alignment/pose_tracker.hpp"
#include "drivers/simulated/synthetic/truth.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

using namespace afterglow;

namespace {

const SyntheticOptions options{
    .width = 320, .height = 240, .fps = 30, .seed = 4, .real_time = false, .noise = false};

/// The synthetic room's image 0 as a template, and image k, which a test may spoil.
struct Pair {
    explicit Pair(std::uint64_t k)
        : truth(options), luma(truth.luma(k)),
          motion(truth.world_to_camera(k) * truth.world_to_camera(0).inverse()),
          reference(truth.intrinsics(), TemplateOptions{}) {
        const Intrinsics &camera = truth.intrinsics();
        WorkerPool pool(1);
        DepthSurface surface(camera, SurfaceOptions{});
        surface.build(truth.depth(0), pool);
        Pyramid image(camera.width, camera.height, TemplateOptions{}.coarsest_level);
        image.build(truth.luma(0));
        reference.build(image, surface);
    }
    /// `last`: PoseTracker::track()'s.
    Alignment align(const Alignment *last = nullptr) const {
        const Intrinsics &camera = truth.intrinsics();
        Pyramid image(camera.width, camera.height, TemplateOptions{}.coarsest_level);
        image.build(luma);
        const std::array<Pose, 1> starts{Pose::identity()};
        // A held camera: without it a large occluder can make a turn look like a shift.
        constexpr float reach_m = 0.03f;
        PosePrior prior;
        prior.information.topLeftCorner<3, 3>().diagonal().setConstant(1 / (reach_m * reach_m));
        WorkerPool pool(1);
        PoseTracker tracker(AlignmentOptions{}, TemplateOptions{}.points_per_level, pool);
        return tracker.track(reference, image, starts, prior, last);
    }
    /// Mean image error, pixels, of a pose for points 2 m ahead.
    double error_px(const Pose &pose) const {
        const Intrinsics &camera = truth.intrinsics();
        double sum = 0;
        for (const double u : {0.2, 0.5, 0.8})
            for (const double v : {0.2, 0.5, 0.8}) {
                const Eigen::Vector3d X =
                    camera.back_project(u * camera.width, v * camera.height, 2.0);
                sum += (camera.project(pose * X) - camera.project(motion * X)).norm() / 9;
            }
        return sum;
    }

    SyntheticTruth truth;
    Luma luma;
    Pose motion;
    AlignmentTemplate reference;
};

} // namespace

TEST_CASE("direct alignment is accurate to a fraction of a pixel", "[core]") {
    const Pair pair(GENERATE(1, 4, 8));
    REQUIRE(pair.error_px(Pose::identity()) > 0.5);
    const Alignment alignment = pair.align();
    REQUIRE(alignment.good);
    CHECK(pair.error_px(alignment.pose) < 0.1);
    CHECK(alignment.inlier_share > 0.8f);
}

TEST_CASE("an image that is not where the one before was is looked for on all levels", "[core]") {
    const int k = GENERATE(0, 1, 4, 8, 16, 30);
    Pair pair(0);
    const Alignment last = pair.align();
    REQUIRE(last.good);
    pair.luma = pair.truth.luma(static_cast<std::uint64_t>(k));
    const Alignment searched = pair.align(), next = pair.align(&last);
    CAPTURE(k, searched.cost, next.cost);
    REQUIRE(searched.good);
    REQUIRE(next.good);
    const Pose apart = searched.pose.inverse() * next.pose;
    CHECK(apart.T.norm() < 1e-3);
    CHECK(apart.angle() < 3e-4);
}

TEST_CASE("direct alignment separates a change of exposure from a change of pose", "[core]") {
    Pair pair(4);
    for (std::uint8_t &grey : pair.luma.pixels())
        grey = static_cast<std::uint8_t>(std::min(255.0, 20 + 0.8 * grey));
    const Alignment alignment = pair.align();
    REQUIRE(alignment.good);
    CHECK(pair.error_px(alignment.pose) < 0.1);
    CHECK(alignment.gain == Approx(0.8).margin(0.02));
    // The gain is about a grey value of 128 or so; what counts is what it makes of the greys.
    CHECK(alignment.gain * 100 + alignment.offset == Approx(100).margin(3));
}

TEST_CASE("direct alignment knows that a camera shows nothing brighter than white", "[core]") {
    Pair pair(4);
    const double gain = GENERATE(1.4, 1.55, 1.7);
    double white_pixels = 0;
    for (std::uint8_t &grey : pair.luma.pixels()) {
        white_pixels += gain * grey > 255;
        grey = static_cast<std::uint8_t>(std::min(255.0, gain * grey));
    }
    CAPTURE(gain, white_pixels);
    REQUIRE(white_pixels > 0.05 * options.width * options.height);
    const Alignment alignment = pair.align();
    CAPTURE(alignment.gain, alignment.offset);
    REQUIRE(alignment.good);
    CHECK(pair.error_px(alignment.pose) < 0.1);
    CHECK(alignment.gain * 100 + alignment.offset == Approx(100 * gain).margin(3));
    CHECK(alignment.inlier_share > 0.8f);
}

TEST_CASE("direct alignment finds the pose of an image whose exposure jumped by up to a stop",
          "[core]") {
    const int k = GENERATE(1, 3, 4, 6, 8);
    const double gain = GENERATE(0.5, 0.6, 1.6, 1.7, 1.8);
    CAPTURE(k, gain);
    Pair pair(static_cast<std::uint64_t>(k));
    for (std::uint8_t &grey : pair.luma.pixels())
        grey = static_cast<std::uint8_t>(std::min(255.0, gain * grey));
    const Alignment alignment = pair.align();
    CAPTURE(alignment.gain, alignment.offset, alignment.inlier_share);
    REQUIRE(alignment.good);
    CHECK(pair.error_px(alignment.pose) < 0.3);
    CHECK(alignment.gain * 100 + alignment.offset == Approx(100 * gain).margin(4));
}

TEST_CASE("direct alignment is robust to an occluder over a third of the image", "[core]") {
    Pair pair(4);
    for (int v = 0; v < options.height; ++v)
        for (int u = 60; u < 60 + options.width / 3; ++u)
            pair.luma(u, v) = static_cast<std::uint8_t>((u * 7 + v * 13) % 256);
    const Alignment alignment = pair.align();
    REQUIRE(alignment.good);
    CHECK(pair.error_px(alignment.pose) < 0.15);
    CHECK(alignment.inlier_share < 0.85f);
}

TEST_CASE("the covariance of an aligned pose grows with the noise of the image", "[core]") {
    float before = 0;
    for (const double deviation : {0.0, 1.0, 3.0, 9.0}) { // grey values
        Pair pair(0);
        std::mt19937 random(1);
        std::normal_distribution<double> noise(0, deviation);
        if (deviation > 0)
            for (std::uint8_t &grey : pair.luma.pixels())
                grey = static_cast<std::uint8_t>(
                    std::clamp(std::lround(grey + noise(random)), 0l, 255l));
        const Alignment alignment = pair.align();
        CAPTURE(deviation);
        REQUIRE(alignment.good);
        const float variance = alignment.covariance.trace();
        CHECK(std::isfinite(variance));
        CHECK(variance > 2 * before);
        before = variance;
    }
}

TEST_CASE("direct alignment rejects a uniform image", "[core]") {
    Pair pair(1);
    std::ranges::fill(pair.luma.pixels(), std::uint8_t{90});
    CHECK_FALSE(pair.align().good);
}

TEST_CASE("direct alignment rejects images of other scenes", "[core]") {
    Pair pair(1);
    for (std::uint64_t seed = 100; seed < 130; ++seed) {
        SyntheticOptions other = options;
        other.seed = seed;
        pair.luma = SyntheticTruth(other).luma(0);
        CHECK_FALSE(pair.align().good);
        std::ranges::reverse(pair.luma.pixels());
        CHECK_FALSE(pair.align().good);
    }
}

TEST_CASE("points of a dim image weigh as those of a brighter one", "[core]") {
    SyntheticTruth truth(options);
    const Intrinsics &camera = truth.intrinsics();
    WorkerPool pool(1);
    DepthSurface surface(camera, SurfaceOptions{});
    surface.build(truth.depth(0), pool);
    const auto made_of = [&](double brightness) {
        Luma luma = truth.luma(0);
        for (std::uint8_t &grey : luma.pixels())
            grey = static_cast<std::uint8_t>(std::lround(brightness * grey));
        Pyramid image(camera.width, camera.height, TemplateOptions{}.coarsest_level);
        image.build(luma);
        AlignmentTemplate made(camera, TemplateOptions{});
        made.build(image, surface);
        return made;
    };
    const AlignmentTemplate bright = made_of(0.4), dim = made_of(0.2), black = made_of(0);
    CHECK(bright.contrast() < 0.95f);
    CHECK(dim.contrast() == Approx(bright.contrast() / 2).epsilon(0.1));
    const auto mean_weight = [](const AlignmentTemplate &made) {
        const TemplatePoints &points = made.points(TemplateOptions{}.finest_level);
        return std::accumulate(points.per_s.begin(), points.per_s.begin() + points.count, 0.0f) /
               static_cast<float>(points.count);
    };
    CHECK(mean_weight(dim) == Approx(2 * mean_weight(bright)).epsilon(0.1));
    const auto count = [](const AlignmentTemplate &made, int level) {
        return made.points(level).count;
    };
    CHECK(count(dim, 1) == Approx(count(bright, 1)).epsilon(0.2));
    for (int level = 1; level <= TemplateOptions{}.coarsest_level; ++level)
        CHECK(count(black, level) == 0);
}

TEST_CASE("points of a template are found in an image as a reference computes it", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    Pair pair(4);
    const float brighter = GENERATE(1.0f, 2.0f); // more than a camera shows
    for (std::uint8_t &grey : pair.luma.pixels())
        grey = static_cast<std::uint8_t>(std::min(white, brighter * static_cast<float>(grey)));
    const Intrinsics &full = pair.truth.intrinsics();
    Pyramid image(full.width, full.height, TemplateOptions{}.coarsest_level);
    image.build(pair.luma);
    const int level = 2;
    const GreyView grey = image.level(level);
    const Intrinsics &camera = pair.reference.camera(level);
    const TemplatePoints &points = pair.reference.points(level);
    Placement at;
    at.pose = {rotation({0.01, 0.05, -0.02}), {0.1, 0, -0.05}};
    at.skew = {0.01f, -0.02f, 0.005f};
    at.gain = 0.9f * brighter;
    at.offset = 7;
    constexpr float robust_width = 4;
    std::vector<float> greys(points.x.size());
    find_greys(points, 0, static_cast<int>(greys.size()), grey, camera, at, greys);
    PointsSeen found;
    Residuals residuals;
    int seen = 0, unseen = 0, whites = 0;
    constexpr int at_once = 2 * TemplatePoints::block;
    static_assert(at_once < Residuals::most_points);
    REQUIRE(points.count > at_once);
    for (int first = 0; first < points.count; first += at_once) {
        const int end = std::min(first + at_once, points.blocks_end());
        find_points(points, first, end, grey, camera, at, found);
        find_residuals(points, first, end, found.grey.data(), at, robust_width, residuals);
        for (std::size_t i = 0; i < static_cast<std::size_t>(end - first); ++i) {
            const std::size_t k = static_cast<std::size_t>(first) + i;
            CAPTURE(k);
            const auto check_unseen = [&] {
                REQUIRE(found.grey[i] == -1.0f);
                REQUIRE(residuals.error[i] == 0.0f);
                REQUIRE(residuals.weight[i] == 0.0f);
                REQUIRE(residuals.bin[i] == Residuals::bins);
            };
            if (k >= static_cast<std::size_t>(points.count)) {
                check_unseen();
                continue;
            }
            REQUIRE(greys[k] == found.grey[i]);
            const Eigen::Vector3d X0(points.x[k], points.y[k], points.z[k]);
            const Eigen::Vector3d turn = at.skew.cast<double>() * points.row[k];
            const Eigen::Vector3d X = at.pose * (X0 + turn.cross(X0));
            const Eigen::Vector2d p = camera.project(X);
            const double left = std::min(p.x(), p.y());
            const double beyond =
                std::max(p.x() - (grey.width() - 1.01), p.y() - (grey.height() - 1.01));
            if (std::abs(left) < 1e-3 || std::abs(beyond) < 1e-3)
                continue; // either is right
            if (left < 0 || beyond > 0) {
                check_unseen();
                ++unseen;
                continue;
            }
            REQUIRE(found.u[i] == Approx(p.x()).margin(1e-3));
            REQUIRE(found.v[i] == Approx(p.y()).margin(1e-3));
            REQUIRE(found.depth[i] == Approx(X.z()).margin(1e-4));
            const int u = static_cast<int>(p.x()), v = static_cast<int>(p.y());
            const double fu = p.x() - u, fv = p.y() - v;
            const double value = (1 - fv) * ((1 - fu) * grey(u, v) + fu * grey(u + 1, v)) +
                                 fv * ((1 - fu) * grey(u, v + 1) + fu * grey(u + 1, v + 1));
            REQUIRE(found.grey[i] == Approx(double{grey_step} * value).margin(0.1));
            const float promised = at.gain * points.intensity[k] + at.offset;
            if (greys[k] > nearly_white && promised > white) {
                REQUIRE(residuals.weight[i] == 0.0f);
                REQUIRE(residuals.bin[i] == Residuals::bins);
                ++whites;
                continue;
            }
            const double error = greys[k] - promised;
            REQUIRE(residuals.error[i] == Approx(error).margin(1e-3));
            const double s2 = 1 / (double(points.per_s[k]) * points.per_s[k]);
            const double r2 = error * error / s2, robust = 16 / (r2 + 16);
            REQUIRE(residuals.weight[i] == Approx(robust * robust / s2).epsilon(1e-3));
            REQUIRE(std::abs(residuals.bin[i] - std::min(63.0, std::sqrt(r2) * 8)) < 1.01);
            ++seen;
        }
    }
    CHECK(seen > (brighter == 1 ? 500 : 100));
    CHECK(unseen > 10);
    CHECK((whites > 100) == (brighter > 1));
}

TEST_CASE("a template's derivatives are those of what an image shows at its points", "[core]") {
    const Pair pair(0);
    const Intrinsics &full = pair.truth.intrinsics();
    Pyramid image(full.width, full.height, TemplateOptions{}.coarsest_level);
    image.build(pair.luma);
    const int level = 1;
    const TemplatePoints &points = pair.reference.points(level);
    const auto greys = [&](const Placement &at) {
        std::vector<float> found(points.x.size());
        find_greys(points, 0, static_cast<int>(found.size()), image.level(level),
                   pair.reference.camera(level), at, found);
        return found;
    };
    // The scene moves by x, the camera's image of it by J x: averages over many points, since grey
    // values are linear over a pixel at best.
    for (int k = 0; k < TemplatePoints::by_gain; ++k) {
        const bool shift = k < 3;
        const double size = shift ? 0.004 : 0.002;
        Placement more, less;
        if (k < TemplatePoints::by_skew) {
            more.pose = exp(size * Twist::Unit(k));
            less.pose = exp(-size * Twist::Unit(k));
        } else {
            more.skew[k - TemplatePoints::by_skew] = static_cast<float>(size);
            less.skew = -more.skew;
        }
        const std::vector<float> above = greys(more), below = greys(less);
        double both = 0, squares = 0;
        for (int i = 0; i < points.count; ++i) {
            const auto at = static_cast<std::size_t>(i);
            if (above[at] < 0 || below[at] < 0)
                continue;
            both += points.J(i, k) * (above[at] - below[at]) / (2 * size);
            squares += points.J(i, k) * points.J(i, k);
        }
        CAPTURE(k);
        CHECK(both / squares == Approx(1).margin(0.1));
    }
    for (int i = 0; i < points.count; ++i)
        REQUIRE(points.J(i, TemplatePoints::by_gain) ==
                Approx(0.01 * (points.intensity[static_cast<std::size_t>(i)] - 128)).margin(1e-5));
}
