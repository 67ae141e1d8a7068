// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/statistics.hpp"
#include "tests/catch.hpp"

#include <limits>

using namespace afterglow;

namespace {

FrameEvent event_of(afterglow_source source, bool illuminated, std::int64_t latency_ns = 0) {
    FrameEvent event{};
    event.frame.source = source;
    event.frame.emitter = illuminated ? AFTERGLOW_EMITTER_ON : AFTERGLOW_EMITTER_OFF;
    event.frame.t_ns = 5'000'000'000;
    event.frame.published_ns = event.frame.t_ns + latency_ns;
    return event;
}

} // namespace

TEST_CASE("the duration histogram's percentiles are within three percent at every size", "[ipc]") {
    for (std::int64_t ns = 1; ns < std::numeric_limits<std::int64_t>::max() / 3; ns = ns * 2 + 7) {
        DurationHistogram histogram;
        histogram.add(ns);
        for (const double fraction : {0.0, 0.5, 1.0})
            CHECK(static_cast<double>(histogram.percentile(fraction)) ==
                  Approx(static_cast<double>(ns)).epsilon(0.03));
    }
}

TEST_CASE("the duration histogram's percentiles follow its distribution", "[ipc]") {
    DurationHistogram histogram;
    CHECK(histogram.percentile(0.5) == 0);
    for (int i = 1; i <= 1000; ++i)
        histogram.add(i * 1000);
    CHECK(static_cast<double>(histogram.percentile(0.50)) == Approx(500e3).epsilon(0.03));
    CHECK(static_cast<double>(histogram.percentile(0.99)) == Approx(990e3).epsilon(0.03));
    CHECK(histogram.percentile(0) <= 1030);
    CHECK(static_cast<double>(histogram.percentile(1)) == Approx(1000e3).epsilon(0.03));
}

TEST_CASE("the duration histogram accepts negative and huge durations", "[ipc]") {
    DurationHistogram histogram;
    histogram.add(-1);
    histogram.add(std::numeric_limits<std::int64_t>::min());
    CHECK(histogram.percentile(1) == 0);
    histogram.add(std::numeric_limits<std::int64_t>::max());
    CHECK(static_cast<double>(histogram.percentile(1)) == Approx(9.2e18).epsilon(0.03));
}

TEST_CASE("the statistics count frames by source of depth", "[ipc]") {
    Statistics statistics;
    CHECK(statistics.duty_cycle() == 0);
    statistics.add(event_of(AFTERGLOW_NONE, true)); // lit, but the camera was not awake yet
    statistics.add(event_of(AFTERGLOW_MEASURED, true));
    for (int i = 0; i < 6; ++i)
        statistics.add(event_of(AFTERGLOW_ESTIMATED, false, 2'000'000));
    CHECK(statistics.published() == 8);
    CHECK(statistics.measured() == 1);
    CHECK(statistics.estimated() == 6);
    CHECK(statistics.without_depth() == 1);
    CHECK(statistics.duty_cycle() == 25);
    CHECK(static_cast<double>(statistics.latency_p50()) == Approx(2e6).epsilon(0.03));
}

TEST_CASE("the duty cycle counts images without a frame as well", "[ipc]") {
    Statistics statistics;
    statistics.add(event_of(AFTERGLOW_MEASURED, true));
    FrameEvent event = event_of(AFTERGLOW_ESTIMATED, false);
    event.skipped = 14;
    event.skipped_lit = 3;
    statistics.add(event);
    CHECK(statistics.published() == 2);
    CHECK(statistics.skipped() == 14);
    CHECK(statistics.duty_cycle() == 25);
    statistics.reset();
    CHECK(statistics.skipped() == 0);
    CHECK(statistics.duty_cycle() == 0);
}

TEST_CASE("resetting the statistics clears counts and keeps the last frame's values", "[ipc]") {
    Statistics statistics;
    FrameEvent event = event_of(AFTERGLOW_ESTIMATED, true, 1000);
    statistics.set_losses({3, 5});
    event.frame.expected_mre = 1.25F;
    event.frame.coverage = 93.5F;
    statistics.add(event);
    CHECK(statistics.damaged() == 3);
    CHECK(statistics.missed() == 5);

    statistics.reset();
    CHECK(statistics.published() == 0);
    CHECK(statistics.estimated() == 0);
    CHECK(statistics.damaged() == 0);
    CHECK(statistics.missed() == 0);
    CHECK(statistics.duty_cycle() == 0);
    CHECK(statistics.latency_p99() == 0);
    CHECK(statistics.expected_error() == 1.25);
    CHECK(statistics.coverage() == 93.5);

    statistics.set_losses({4, 7}); // without a frame
    CHECK(statistics.damaged() == 1);
    CHECK(statistics.missed() == 2);
}

TEST_CASE("the statistics' CPU load and power are those measured since the last reset", "[ipc]") {
    Statistics statistics;
    const PowerModel power{.tof_w = 4, .idle_w = 0.5, .core_w = 2};
    CHECK(statistics.cpu_load() == 0);
    FrameEvent event = event_of(AFTERGLOW_ESTIMATED, false);
    statistics.add(event); // the first: no time has passed
    CHECK(statistics.cpu_load() == 0);
    event.stream_ns = 2'000'000'000;
    event.cpu_ns = 3'000'000'000;
    statistics.add(event);
    CHECK(statistics.cpu_load() == Approx(1.5));
    CHECK(statistics.estimated_power(power) == Approx(0.5 + 1.5 * 2));

    statistics.reset();
    CHECK(statistics.cpu_load() == 0);
    CHECK(statistics.estimated_power(power) == Approx(0.5));
    event.stream_ns += 1'000'000'000;
    event.cpu_ns += 250'000'000;
    statistics.add(event);
    CHECK(statistics.cpu_load() == Approx(0.25));
}

TEST_CASE("the statistics' pairing errors and wake latencies are over arrived measurements") {
    Statistics statistics;
    statistics.add(event_of(AFTERGLOW_ESTIMATED, false));
    CHECK(statistics.pairing_error_p99() == 0);
    CHECK(statistics.wake_latency_p50() == 0);
    FrameEvent measured = event_of(AFTERGLOW_MEASURED, true);
    measured.pairing_error_ns = 3'000'000;
    measured.wake_latency_ns = 99'000'000;
    statistics.add(measured);
    statistics.add(event_of(AFTERGLOW_ESTIMATED, false));
    CHECK(static_cast<double>(statistics.pairing_error_p50()) == Approx(3e6).epsilon(0.03));
    CHECK(static_cast<double>(statistics.pairing_error_p99()) == Approx(3e6).epsilon(0.03));
    CHECK(static_cast<double>(statistics.wake_latency_p50()) == Approx(99e6).epsilon(0.03));
}
