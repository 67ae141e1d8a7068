// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/libcamera_time.hpp"
#include "tests/catch.hpp"

using namespace afterglow::libcam;

namespace {

constexpr std::int64_t second = 1'000'000'000;
constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t period = 33 * ms;
constexpr std::int64_t arrival = 100 * second;

} // namespace

TEST_CASE("a libcamera timestamp of the exposure's start is the capture time") {
    CHECK(capture_time({arrival - 40 * ms, true, arrival}, period, 0) == arrival - 40 * ms);
}

TEST_CASE("a libcamera timestamp of the frame's end is set back by one frame") {
    CHECK(capture_time({arrival - 5 * ms, false, arrival}, period, 0) == arrival - 5 * ms - period);
}

TEST_CASE("libcamera timestamps of either clock are correct after suspend") {
    constexpr std::int64_t asleep = 3600 * second;
    CHECK(capture_time({arrival - 40 * ms, true, arrival}, period, asleep) == arrival - 40 * ms);
    CHECK(capture_time({arrival - 40 * ms + asleep, true, arrival}, period, asleep) ==
          arrival - 40 * ms);
}

TEST_CASE("an impossible libcamera timestamp is replaced by the arrival time") {
    for (const std::int64_t stamp : {std::int64_t{0}, arrival - 3 * second, arrival + second}) {
        CHECK(capture_time({stamp, true, arrival}, period, 0) == arrival - period);
        CHECK(capture_time({stamp, false, arrival}, period, 0) == arrival - period);
    }
}

TEST_CASE("the suspended time is not negative and constant while awake") {
    const std::int64_t asleep = time_asleep_ns();
    CHECK(asleep > -ms);
    CHECK(time_asleep_ns() - asleep < 100 * ms);
}
