// SPDX-License-Identifier: Apache-2.0
#include "core/pose_solver.hpp"
#include "core/ransac.hpp"
#include "tests/catch.hpp"
#include "tests/matches.hpp"

#include <cmath>
#include <cstdio>
#include <random>

using namespace afterglow;

namespace {

struct Corruption {
    const char *what;
    bool depth;
    bool flow;
    double paper_reduction; ///< percent, Table II
};

/// Root mean square of the translation error over `trials` random motions, metres, without and
/// with RANSAC. Flow is rounded to whole pixels, as the three-step search gives it; of each thing
/// to corrupt a fifth is.
std::pair<double, double> translation_rmse(const Corruption &corruption, int trials) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    double plain = 0;
    double robust = 0;
    for (int trial = 0; trial < trials; ++trial) {
        const auto vector = [&](double sigma) -> Eigen::Vector3d {
            return Eigen::Vector3d(normal(random), normal(random), normal(random)) * sigma;
        };
        const Pose truth{rotation(vector(0.01)), vector(0.02)};
        auto matches = exact_matches(truth, 144, static_cast<unsigned>(trial));
        for (Match &match : matches) {
            match.to = (match.to - match.from).array().round().matrix() + match.from;
            if (corruption.depth && uniform(random) < 0.2)
                match.z *= 0.5 + uniform(random);
            if (corruption.flow && uniform(random) < 0.2)
                match.to += Eigen::Vector2d(30 * uniform(random) - 15, 30 * uniform(random) - 15);
        }
        const auto without = solve_pose(matches, test_camera, 3);
        const auto with = RansacPose({}, matches.size()).solve(matches, test_camera);
        REQUIRE(without);
        REQUIRE(with);
        plain += (without->T - truth.T).squaredNorm();
        robust += (with->pose.T - truth.T).squaredNorm();
    }
    return {std::sqrt(plain / trials), std::sqrt(robust / trials)};
}

} // namespace

TEST_CASE("RANSAC lowers the translation error as in the paper's Table II", "[core]") {
    std::printf("corrupted   RMSE, m   with RANSAC   reduction   paper\n");
    for (const Corruption &corruption :
         {Corruption{"depth", true, false, 68.0}, Corruption{"flow", false, true, 59.4},
          Corruption{"both", true, true, 45.1}}) {
        const auto [plain, robust] = translation_rmse(corruption, 300);
        const double reduction = 100 * (1 - robust / plain);
        std::printf("%-9s   %7.4f   %11.4f   %7.1f %%   %4.1f %%\n", corruption.what, plain, robust,
                    reduction, corruption.paper_reduction);
        CHECK(reduction > 30);
    }
}

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

TEST_CASE("no pose stands when no tenth of the matches agree", "[core]") {
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

TEST_CASE("too few matches give no pose", "[core]") {
    RansacPose ransac({}, 10);
    for (int count : {0, 1, 2})
        CHECK_FALSE(ransac.solve(exact_matches(Pose::identity(), count), test_camera));
}
