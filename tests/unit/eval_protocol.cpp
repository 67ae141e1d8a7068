// SPDX-License-Identifier: Apache-2.0
#include "eval/protocol.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

namespace {

FrameScore estimated(double expected, double actual) {
    FrameScore frame;
    frame.expected_mre = expected;
    frame.mre = actual;
    return frame;
}

FrameScore measured() {
    FrameScore frame = estimated(0, 0);
    frame.measured = true;
    return frame;
}

} // namespace

TEST_CASE("expected errors are compared with true ones from the third measurement on", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(),      estimated(1, 9),   measured(),      estimated(1, 9),
                         measured(),      estimated(1, 0.5), estimated(1, 1), estimated(2, 4),
                         estimated(2, 6), FrameScore{}};
    const ExpectedAgainstTrue e = expected_against_true(evaluation);
    REQUIRE(e.ratio);
    CHECK(*e.ratio == Approx(1.5)); // of 0.5, 1, 2, 3
    CHECK(*e.over == Approx(50));
    CHECK(*e.correlation > 0.9);
}

TEST_CASE("an evaluation of two measurements says nothing of the expected error", "[eval]") {
    Evaluation evaluation;
    evaluation.frames = {measured(), estimated(1, 2), measured(), estimated(1, 2)};
    const ExpectedAgainstTrue e = expected_against_true(evaluation);
    CHECK_FALSE(e.ratio);
    CHECK_FALSE(e.over);
    CHECK_FALSE(e.correlation);
}
