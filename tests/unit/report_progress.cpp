// SPDX-License-Identifier: Apache-2.0
#include "eval/progress.hpp"
#include "tests/catch.hpp"

using namespace afterglow;
using std::chrono::seconds;

TEST_CASE("a progress line shows the percentage and the time left", "[report]") {
    CHECK(progress_line("room", 0, seconds(5)) == "[--------------------]   0 %, 5 s left: room");
    CHECK(progress_line("room", 0.259, seconds(90)) ==
          "[#####---------------]  25 %, 1 min 30 s left: room");
    CHECK(progress_line("room", 1, seconds(0)) == "[####################] 100 %, 0 s left: room");
}
