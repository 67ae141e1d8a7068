// SPDX-License-Identifier: Apache-2.0
#include "core/paper/pose_solver.hpp"
#include "tests/catch.hpp"
#include "tests/matches.hpp"

#include <limits>

using namespace afterglow;
using Eigen::Vector3d;

TEST_CASE("the pose solver recovers known poses from exact matches", "[core]") {
    for (const Pose &truth : {Pose{rotation({0, 0, 0}), {0.01, -0.02, 0.03}},
                              Pose{rotation({0.01, -0.02, 0.015}), {0, 0, 0}},
                              Pose{rotation({-0.05, 0.08, 0.03}), {0.05, 0.02, -0.1}},
                              Pose{rotation({0.2, -0.1, 0.15}), {0.1, 0.1, 0.2}}}) {
        const auto matches = exact_matches(truth, 144);
        const auto pose = solve_pose(matches, test_camera, 30);
        REQUIRE(pose);
        CHECK((pose->R - truth.R).norm() < 1e-6);
        CHECK((pose->T - truth.T).norm() < 1e-6);
    }
}

TEST_CASE("the pose solver needs three matches", "[core]") {
    const Pose truth{rotation({0.01, 0.02, -0.01}), {0.02, 0, 0.01}};
    const auto matches = exact_matches(truth, 3);
    const auto pose = solve_pose(matches, test_camera, 30);
    REQUIRE(pose);
    CHECK((pose->T - truth.T).norm() < 1e-6);
}

TEST_CASE("the pose solver is exact after one iteration for pure translation", "[core]") {
    const Pose truth{Eigen::Matrix3d::Identity(), {0.05, -0.03, 0.08}};
    const auto pose = solve_pose(exact_matches(truth, 20), test_camera, 1);
    REQUIRE(pose);
    CHECK((pose->T - truth.T).norm() < 1e-9);
}

TEST_CASE("the pose solver's residual is the reprojection error times Y_z / z", "[core]") {
    const Pose pose{rotation({0.03, -0.02, 0.05}), {0.1, 0.05, 0.3}};
    const Match match{.from = {100, 300}, .to = {120.5, 290.25}, .z = 1.7};
    const Vector3d Y = pose * test_camera.back_project(100, 300, 1.7);
    const double error = (test_camera.project(Y) - match.to).norm() * Y.z() / 1.7;
    CHECK(squared_residual(match, test_camera, pose) == Approx(error * error));
}

TEST_CASE("the pose solver refuses fewer than three matches and collinear points", "[core]") {
    const Pose truth{rotation({0.01, 0.02, -0.01}), {0.02, 0, 0.01}};
    CHECK_FALSE(solve_pose({}, test_camera, 3));
    CHECK_FALSE(solve_pose(exact_matches(truth, 2), test_camera, 3));
    std::vector<Match> line;
    for (int i = 0; i < 10; ++i)
        line.push_back(
            exact_match(truth, Vector3d(-0.5, 0.2, 2) + 0.1 * i * Vector3d(1, 0.5, 0.3)));
    CHECK_FALSE(solve_pose(line, test_camera, 3));
}

TEST_CASE("the pose solver refuses a repeated match", "[core]") {
    const Match match = exact_match(Pose::identity(), {0.3, 0.2, 2});
    CHECK_FALSE(solve_pose(std::vector<Match>(50, match), test_camera, 3));
}

TEST_CASE("the pose solver refuses a pose that moves a point behind the camera", "[core]") {
    // A far scene that rushes towards the camera by 2 m, and a near point that would be passed.
    const Pose truth{Eigen::Matrix3d::Identity(), {0, 0, -2}};
    std::vector<Match> matches;
    for (const Vector3d &X : {Vector3d(1, 0, 4), {-1, 1, 5}, {0.5, -1, 6}, {-1, -1, 4}, {1, 1, 7}})
        matches.push_back(exact_match(truth, X));
    REQUIRE(solve_pose(matches, test_camera, 1));
    const Vector3d passed(0.2, 0.1, 1);
    matches.push_back({.from = test_camera.project(passed),
                       .to = test_camera.project(truth * passed), // the image of a point behind
                       .z = passed.z()});
    CHECK_FALSE(solve_pose(matches, test_camera, 1));
}

TEST_CASE("the pose solver refuses matches of NaN", "[core]") {
    auto matches = exact_matches(Pose::identity(), 10);
    matches[4].to.x() = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(solve_pose(matches, test_camera, 3));
    matches[4].to.x() = std::numeric_limits<double>::infinity();
    CHECK_FALSE(solve_pose(matches, test_camera, 3));
}
