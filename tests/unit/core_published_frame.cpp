// SPDX-License-Identifier: Apache-2.0
#include "core/paper/published_frame.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

TEST_CASE("a published frame's age counts all images since the measurement", "[core]") {
    PublishedFrame frame({20, 20, 7.5, 5.5, 16, 12});
    CHECK_FALSE(frame.has_depth());
    frame.begin(100);
    CHECK(frame.give_nothing().wants_measurement);
    DepthMap depth(16, 12, 1000);
    depth(0, 0) = 0;
    CHECK(frame.give_measured(depth).source == FrameSource::measured);
    CHECK(frame.has_depth());

    frame.begin(110);
    const Estimate &e = frame.give_nothing();
    CHECK(e.age_frames == 0);
    CHECK(e.age_ns == 0);
    CHECK(e.coverage == 0);
    CHECK(e.confidence(1, 0) == 0);

    frame.begin(120);
    frame.depth()(3, 2) = 900;
    frame.give_estimated();
    CHECK(e.age_frames == 2);
    CHECK(e.age_ns == 20);
    CHECK(e.coverage == Approx(100.0 / (16 * 12)));
    CHECK(e.confidence(3, 2) == unknown_confidence);
    CHECK(e.confidence(0, 0) == 0);
    CHECK_FALSE(e.wants_measurement);
}
