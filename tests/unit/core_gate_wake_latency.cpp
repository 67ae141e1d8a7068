// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/gates.hpp"

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("a slow wake costs light and no accuracy: measurements arrive as often", "[core]") {
    const auto growing = [](int k) { return expecting(0.9f + 0.1f * static_cast<float>(k)); };
    Gate quick = measured_gate({.target_mre = 5});
    Gate slow = measured_gate({.target_mre = 5}, 3);
    const int arrival = first_lit(slow, 50, growing) + 3;
    CHECK(std::abs(arrival - first_lit(quick, 50, growing)) <= 1);
}

TEST_CASE("the gate learns how long a measurement takes to arrive", "[core]") {
    CHECK(measured_gate({}).wake_latency_frames() == 0);
    Gate gate = measured_gate({}, 3);
    CHECK(gate.wake_latency_frames() == 3);
    CHECK(gate.wants_light(bad));
    gate.measured();
    CHECK(gate.wake_latency_frames() == 0);
}

TEST_CASE("the gate lights early by the TOF camera's wake latency", "[core]") {
    const int latency = GENERATE(1, 3, 5);
    INFO(latency);
    SECTION("in mode interval") {
        Gate gate = measured_gate({.mode = GateMode::interval, .interval_frames = 10}, latency);
        CHECK(first_lit(gate, 100, [](int) { return good; }) == 10 - latency);
    }
    SECTION("at the longest interval") {
        Gate gate = measured_gate({.longest_interval_frames = 30}, latency);
        CHECK(first_lit(gate, 100, [](int) { return expecting(0.1); }) == 30 - latency);
    }
    SECTION("for a linearly growing error") {
        Gate gate = measured_gate({.target_mre = 1.2, .measurement_price = 0}, latency);
        // 1.2 % is passed with image 21.
        const int lit = first_lit(gate, 100, [](int k) { return expecting(0.2 + 0.05 * k); });
        CHECK(lit >= 21 - latency - 1);
        CHECK(lit <= 21 - latency + 1);
    }
    SECTION("for linearly shrinking coverage") {
        Gate gate = measured_gate({.coverage_floor = 70}, latency);
        // 70 % is left with image 16.
        const int lit = first_lit(gate, 100, [](int k) { return expecting(0.1, 101.5 - 2 * k); });
        CHECK(lit >= 16 - latency - 1);
        CHECK(lit <= 16 - latency + 1);
    }
}

namespace {

/// Of a gate whose light takes `latency` images to wake, and whose map becomes worse by 0.5 % an
/// image, from 1 % on: it has seen that once, and the next measurement has just arrived. A fresh
/// map is expected to be wrong by `fresh`, percent.
Gate gate_after_a_cycle(GatePolicy policy, int latency, double fresh = 0.2) {
    policy.measurement_price = 0;
    Gate gate = measured_gate(policy, latency);
    int k = 0;
    const auto worse = [&] { return expecting(0.5 + 0.5 * ++k, 100, fresh); };
    while (!gate.wants_light(worse()))
        REQUIRE(k < 100);
    for (int i = 0; i < latency; ++i)
        REQUIRE(gate.wants_light(worse()));
    gate.measured();
    return gate;
}

} // namespace

TEST_CASE("a camera that would wake too late to keep the target stays lit", "[core]") {
    // Dark from now on, the next map would be wrong by 1 + 3 x 0.5 % when it is measured.
    Gate gate = gate_after_a_cycle({.target_mre = 2.4}, 3);
    for (int k = 0; k < 20; ++k) {
        REQUIRE(gate.keeps_light());
        REQUIRE(gate.wants_light(expecting(1, 100, 0.2)));
        CHECK(gate.reason() == GateReason::error);
        gate.measured();
    }
    CHECK(gate.wake_latency_frames() == 3); // a light that was on tells nothing of it
    SECTION("until carrying a map adds less to its error") {
        // 0.6 + 3 x 0.5 x (0.6 - 0.2) / (1 - 0.2) %
        CHECK(gate.wants_light(expecting(0.6, 100, 0.2)));
        gate.measured();
        CHECK_FALSE(gate.keeps_light());
        CHECK_FALSE(gate.wants_light(expecting(0.6, 100, 0.2)));
    }
    SECTION("until somebody sets another mode") {
        gate.set_policy({.mode = GateMode::interval});
        CHECK_FALSE(gate.keeps_light());
        CHECK_FALSE(gate.wants_light(expecting(1, 100, 0.2)));
    }
    SECTION("until the cameras pause") {
        gate.restart();
        CHECK_FALSE(gate.keeps_light());
    }
}

TEST_CASE("a light that is kept on goes out now and then, to see how the error grows", "[core]") {
    Gate gate = gate_after_a_cycle({.target_mre = 2.4}, 3);
    int kept = 0;
    for (; gate.keeps_light() && kept < 1000; ++kept) {
        REQUIRE(gate.wants_light(expecting(1, 100, 0.2)));
        gate.measured();
    }
    CHECK(kept > 20);
    CHECK(kept < 30);
    CHECK_FALSE(gate.wants_light(expecting(1, 100, 0.2)));
}

TEST_CASE("a lost view does not keep the light on afterwards", "[core]") {
    Gate gate = measured_gate({.target_mre = 2.4, .measurement_price = 0}, 3);
    gate.wants_light(expecting(1, 100, 0.2));
    Estimate lost = expecting(100, 0, 0.2);
    lost.wants_measurement = true;
    for (int i = 0; i <= 3; ++i)
        REQUIRE(gate.wants_light(lost));
    gate.measured();
    CHECK_FALSE(gate.keeps_light());
}

TEST_CASE("a camera goes dark where it wakes in time, or light would not help", "[core]") {
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 2.6}, 3).keeps_light());
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 0.9}, 0).keeps_light());
    // A fresh map would be wrong by 32 % of what the dark one would be.
    CHECK(gate_after_a_cycle({.target_mre = 2.4, .worthwhile = 33}, 3, 0.8).keeps_light());
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 2.4, .worthwhile = 31}, 3, 0.8).keeps_light());
    CHECK_FALSE(
        gate_after_a_cycle({.target_mre = 2.4, .shortest_interval_frames = 3}, 3).keeps_light());
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 2.4, .duty_cycle_budget = 0.1}, 3).keeps_light());
}

TEST_CASE("the gate does not extrapolate a falling error upwards", "[core]") {
    Gate gate = measured_gate({.target_mre = 1.2}, 5);
    CHECK(first_lit(gate, 50, [](int k) { return expecting(1.1 - 0.01 * k); }) == 0);
}
