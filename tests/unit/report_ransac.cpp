// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/ransac_experiment.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

TEST_CASE("the RANSAC simulation lowers the translation error as in the paper's Table II",
          "[report]") {
    const auto scores = simulate_ransac(300);
    REQUIRE(scores.size() == 3);
    for (const RansacScore &score : scores) {
        INFO(score.depth << score.flow);
        CHECK((score.depth || score.flow));
        CHECK(score.plain_rmse_m > 0.002);
        CHECK(score.plain_rmse_m < 0.05);
        CHECK(score.reduction() > 30);
        CHECK(score.reduction() < 100);
    }
}

TEST_CASE("the RANSAC simulation's reduction is the error's, in percent", "[report]") {
    CHECK(RansacScore{.plain_rmse_m = 0.02, .ransac_rmse_m = 0.005}.reduction() == Approx(75));
}
