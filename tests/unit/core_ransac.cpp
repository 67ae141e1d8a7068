// SPDX-License-Identifier: Apache-2.0
#include "core/paper/pose_solver.hpp"
#include "core/paper/ransac.hpp"
#include "tests/catch.hpp"
#include "tests/matches.hpp"

#include <random>

using namespace afterglow;

TEST_CASE("RANSAC finds the pose among gross outliers", "[core]") {
    const Pose truth{rotation({0.01, -0.02, 0.01}), {0.03, 0.01, -0.02}};
    auto matches = exact_matches(truth, 100);
    for (std::size_t i = 0; i < 40; ++i)
        matches[i].to += Eigen::Vector2d(10 + static_cast<double>(i), -15);
    const auto solution = RansacPose({.threshold = 1}, 100).solve(matches, test_camera);
    REQUIRE(solution);
    CHECK(solution->inliers <= 60);
    CHECK((solution->pose.T - truth.T).norm() < 1e-3);
}

TEST_CASE("RANSAC refuses a pose with fewer than 10 % inliers", "[core]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(0, 639), v(0, 479), z(1, 4);
    std::vector<Match> matches;
    for (int i = 0; i < 144; ++i)
        matches.push_back(
            {.from = {u(random), v(random)}, .to = {u(random), v(random)}, .z = z(random)});
    CHECK_FALSE(RansacPose({}, 144).solve(matches, test_camera));
}

TEST_CASE("RANSAC gives the same pose for the same seed", "[core]") {
    auto matches = exact_matches({rotation({0.01, 0, 0.02}), {0.01, 0.02, 0}}, 144);
    for (Match &match : matches)
        match.to = match.to.array().round();
    const auto first = RansacPose({.threshold = 0.1, .seed = 5}, 144).solve(matches, test_camera);
    const auto again = RansacPose({.threshold = 0.1, .seed = 5}, 144).solve(matches, test_camera);
    const auto other = RansacPose({.threshold = 0.1, .seed = 6}, 144).solve(matches, test_camera);
    REQUIRE(first);
    REQUIRE(again);
    REQUIRE(other);
    CHECK(first->pose.T == again->pose.T);
    CHECK(first->pose.T != other->pose.T);
}

TEST_CASE("RANSAC gives no pose for too few matches", "[core]") {
    RansacPose ransac({}, 10);
    for (int count : {0, 1, 2})
        CHECK_FALSE(ransac.solve(exact_matches(Pose::identity(), count), test_camera));
}
