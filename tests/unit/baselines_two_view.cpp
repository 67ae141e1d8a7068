// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/two_view.hpp"
#include "tests/catch.hpp"
#include "tests/matches.hpp"

#include <random>
#include <vector>

using namespace afterglow;

namespace {

std::vector<PixelPair> pairs_of(const std::vector<Match> &matches) {
    std::vector<PixelPair> pairs;
    for (const Match &match : matches)
        pairs.push_back({{static_cast<float>(match.from.x()), static_cast<float>(match.from.y())},
                         {static_cast<float>(match.to.x()), static_cast<float>(match.to.y())}});
    return pairs;
}

const Pose step{rotation({0.01, -0.02, 0.005}), {0.2, -0.05, 0.1}};

} // namespace

TEST_CASE("two-view triangulation gives true depth up to the baseline length", "[baselines]") {
    const auto matches = exact_matches(step, 200);
    auto pairs = pairs_of(matches);
    const auto check = [&](std::size_t least) {
        const auto points = triangulate(pairs, test_camera);
        CHECK(points.size() >= least);
        for (const ScenePoint &point : points) {
            const auto match = std::ranges::min_element(
                matches, {}, [&](const Match &m) { return (m.to - point.pixel).squaredNorm(); });
            const double z =
                (step * test_camera.back_project(match->from.x(), match->from.y(), match->z)).z();
            CHECK(point.z * step.T.norm() == Approx(z).epsilon(0.02));
        }
    };
    SECTION("exact correspondences") {
        check(190);
    }
    SECTION("a quarter of the correspondences are outliers") {
        std::mt19937 random(1);
        std::uniform_real_distribution<float> anywhere(0, 479);
        for (std::size_t i = 0; i < pairs.size(); i += 4)
            pairs[i].to = {anywhere(random), anywhere(random)};
        const auto points = triangulate(pairs, test_camera);
        CHECK(points.size() >= 140);
        CHECK(points.size() < 160);
    }
}

TEST_CASE("degenerate two-view correspondences give no points or finite ones", "[baselines]") {
    CHECK(triangulate({}, test_camera).empty());
    const auto some = pairs_of(exact_matches(step, 7));
    CHECK(triangulate(some, test_camera).empty());

    std::vector<PixelPair> pairs(50, {{10, 10}, {12, 10}});
    for (const ScenePoint &point : triangulate(pairs, test_camera))
        CHECK(std::isfinite(point.z));
    for (std::size_t i = 0; i < pairs.size(); ++i) // nothing moves
        pairs[i] = {{10.f * static_cast<float>(i), 7.f * static_cast<float>(i * i % 60)},
                    {10.f * static_cast<float>(i), 7.f * static_cast<float>(i * i % 60)}};
    for (const ScenePoint &point : triangulate(pairs, test_camera))
        CHECK(std::isfinite(point.z));
}

TEST_CASE("the scale of a depth map of unknown scale is fitted to the true depth", "[baselines]") {
    std::mt19937 random(1);
    DepthMap truth(64, 48);
    for (std::uint16_t &z : truth.pixels())
        z = static_cast<std::uint16_t>(1000 + random() % 3000);
    std::vector<ScenePoint> points;
    for (int v = 0; v < 48; v += 4)
        for (int u = 0; u < 64; u += 4)
            points.push_back({{u + 0.3, v - 0.3}, truth(u, v) / 1000.0 / 0.037});
    CHECK(*fit_scale(points, truth) == Approx(0.037));

    SECTION("a third of the points is too near or has no true depth") {
        for (std::size_t i = 0; i < points.size(); i += 3)
            points[i].z *= 0.4;
        for (std::size_t i = 1; i < points.size(); i += 3)
            truth(static_cast<int>(points[i].pixel.x()),
                  static_cast<int>(points[i].pixel.y() + 1)) = 0;
        CHECK(*fit_scale(points, truth) == Approx(0.037));
    }
    SECTION("the fit minimises the mean relative error") {
        for (ScenePoint &point : points)
            point.z *= std::uniform_real_distribution<double>(0.3, 3)(random);
        const auto mre = [&](double scale) {
            double sum = 0;
            for (const ScenePoint &point : points) {
                const auto at = *pixel_of(point, 64, 48);
                const double z = truth(at.x(), at.y()) / 1000.0;
                sum += std::abs(z - scale * point.z) / z;
            }
            return sum;
        };
        const double scale = *fit_scale(points, truth);
        CHECK(mre(scale) <= mre(0.99 * scale));
        CHECK(mre(scale) <= mre(1.01 * scale));
    }
    SECTION("without true depth there is no scale") {
        CHECK_FALSE(fit_scale({}, truth));
        CHECK_FALSE(fit_scale(points, DepthMap(64, 48)));
    }
}
