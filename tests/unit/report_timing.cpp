// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/timing.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

TEST_CASE("timings are compared within a round", "[report]") {
    Stopwatches watches({"a", "b"}, "a");
    watches.add_round({1, 2});
    watches.add_round({100, 200}); // something else kept the machine busy
    watches.add_round({1, 4});
    const auto timings = watches.timings();
    REQUIRE(timings.size() == 2);
    CHECK(timings[0].ratio == 1);
    CHECK(timings[1].ratio == 2);
    CHECK(timings[1].ratio_q1 == 2);
    CHECK(timings[1].ratio_q3 == 3);
    CHECK(timings[1].ms == 4);
    CHECK(timings[1].rounds == 3);
}

TEST_CASE("a timing round without the reference or the subject is not counted", "[report]") {
    Stopwatches watches({"a", "b"}, "a");
    watches.add_round({-1, 2});
    CHECK(watches.timings().empty());
    watches.add_round({1, -1});
    CHECK(watches.timings().size() == 1);
    CHECK(watches.rounds() == 0);
    watches.add_round({1, 3});
    CHECK(watches.rounds() == 1);
}
