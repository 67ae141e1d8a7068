// SPDX-License-Identifier: Apache-2.0
#include "drivers/timestamps/device_clock.hpp"
#include "tests/catch.hpp"

#include <cmath>
#include <cstdint>

using namespace afterglow;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t frame_ns = 33'333'333;

/// A camera whose clock began at some time, runs at some rate, and whose frames take from 5 ms to
/// some time more to arrive.
struct Camera {
    double ppm = 0; ///< its clock is too fast by this
    std::int64_t jitter_ns = 4 * ms;
    std::int64_t clock_begin_ns = 77'000 * ms;

    std::int64_t device_ns(std::int64_t t_ns) const {
        return clock_begin_ns + t_ns + std::llround(static_cast<double>(t_ns) * ppm * 1e-6);
    }
    std::int64_t arrival_ns(std::int64_t t_ns) {
        noise_ = noise_ * 1664525U + 1013904223U;
        return t_ns + 5 * ms +
               static_cast<std::int64_t>(noise_ >> 8) % (jitter_ns + 1); // mostly not the least
    }

private:
    std::uint32_t noise_ = 1;
};

/// The greatest error of frames from `from` to `to`, s, over the 5 ms that all take at least.
double worst_ms(DeviceClock &clock, Camera &camera, double from, double to) {
    double worst = 0;
    for (auto t_ns = static_cast<std::int64_t>(from * 1e9);
         t_ns < static_cast<std::int64_t>(to * 1e9); t_ns += frame_ns) {
        const std::int64_t told =
            clock.to_monotonic(camera.device_ns(t_ns), camera.arrival_ns(t_ns));
        worst = std::max(worst, std::abs(static_cast<double>(told - t_ns - 5 * ms)) * 1e-6);
    }
    return worst;
}

} // namespace

TEST_CASE("the device clock's offset is taken from the frames of least delay") {
    DeviceClock clock;
    Camera camera;
    CHECK(worst_ms(clock, camera, 0, 1) <= 4); // the first ones are not better than they came
    CHECK(worst_ms(clock, camera, 1, 60) < 0.5);
}

TEST_CASE("the device clock follows drift") {
    DeviceClock clock;
    Camera camera;
    camera.ppm = GENERATE(-200, -20, 50, 200);
    worst_ms(clock, camera, 0, 60);
    CHECK(worst_ms(clock, camera, 60, 600) < 1);
    CHECK(clock.drift_ppm() == Approx(-camera.ppm).margin(15));
}

TEST_CASE("the device clock gives the capture time of frames that are read late") {
    DeviceClock clock;
    Camera camera;
    worst_ms(clock, camera, 0, 5);
    const std::int64_t t_ns = 5'000 * ms;
    const std::int64_t told = clock.to_monotonic(camera.device_ns(t_ns), t_ns + 300 * ms);
    CHECK(std::abs(told - t_ns - 5 * ms) < ms);
}

TEST_CASE("the device clock follows a reset or a jump") {
    DeviceClock clock;
    Camera camera;
    worst_ms(clock, camera, 0, 30);
    SECTION("reset to zero") {
        camera.clock_begin_ns = -30'000 * ms;
    }
    SECTION("jump forwards") {
        camera.clock_begin_ns += 3'000 * ms;
    }
    SECTION("jump backwards") {
        camera.clock_begin_ns -= 700 * ms;
        worst_ms(clock, camera, 30.75, 31); // until there are enough of them
    }
    CHECK(worst_ms(clock, camera, 31, 32) <= 4);
    CHECK(worst_ms(clock, camera, 32, 60) < 0.5);
}

TEST_CASE("the device clock stays near monotonic time when its counter stands still") {
    DeviceClock clock;
    std::int64_t told = 0;
    for (std::int64_t t_ns = 0; t_ns < 10'000 * ms; t_ns += frame_ns)
        told = clock.to_monotonic(0, t_ns);
    CHECK(std::abs(told - 10'000 * ms) < 1'000 * ms);
}
