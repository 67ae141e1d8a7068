// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/metrics.hpp"
#include "tests/catch.hpp"

#include <cmath>

using namespace afterglow;

namespace {

DepthMap map_of(std::initializer_list<std::uint16_t> depths) {
    DepthMap map(static_cast<int>(depths.size()), 1);
    int u = 0;
    for (std::uint16_t depth : depths)
        map(u++, 0) = depth;
    return map;
}

} // namespace

TEST_CASE("the error metrics are those of the paper", "[core]") {
    const DepthErrors errors =
        compare_depth(map_of({1010, 1960, 4000}), map_of({1000, 2000, 4000}));
    CHECK(errors.mre == Approx((1.0 + 2.0 + 0.0) / 3));
    CHECK(errors.mae_cm == Approx((1.0 + 4.0 + 0.0) / 3));
    CHECK(errors.rmse_cm == Approx(std::sqrt((1.0 + 16.0) / 3)));
    CHECK(errors.coverage() == 100);
}

TEST_CASE("error metrics ignore pixels without true depth, and missing pixels lower the coverage",
          "[core]") {
    const DepthErrors errors = compare_depth(map_of({1010, 0, 500, 0}), map_of({1000, 1000, 0, 0}));
    CHECK(errors.pixels == 1);
    CHECK(errors.true_pixels == 2);
    CHECK(errors.mre == Approx(1));
    CHECK(errors.coverage() == 50);
}

TEST_CASE("error metrics of maps without common pixels are 0, not NaN", "[core]") {
    for (const DepthMap &truth : {map_of({0, 0}), map_of({0, 7})}) {
        const DepthErrors errors = compare_depth(map_of({5, 0}), truth);
        CHECK(errors.pixels == 0);
        CHECK(errors.mre == 0);
        CHECK(errors.rmse_cm == 0);
        CHECK(errors.coverage() == 0);
    }
}
