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
/// map is expected to be wrong by `fresh`, percent. Frames are `interval` images apart, but for
/// those that wait.
Gate gate_after_a_cycle(GatePolicy policy, int latency, double fresh = 0.2, int interval = 1) {
    policy.measurement_price = 0;
    Gate gate = measured_gate(policy, latency);
    int k = 0;
    const auto lights = [&] {
        ++k;
        const int after = (k - 1) % interval; // the last frame
        return gate.wants_light(expecting(0.5 + 0.5 * (k - after), 100, fresh), true,
                                {.now = after == 0, .next_in = interval - after});
    };
    while (!lights())
        REQUIRE(k < 100);
    for (int i = 0; i < latency; ++i)
        REQUIRE(gate.wants_light(expecting(0.5 + 0.5 * ++k, 100, fresh), true,
                                 {.now = true, .next_in = interval}));
    gate.measured();
    return gate;
}

/// The first image of 40 after a measurement that wants light, and why, when frames are `interval`
/// images apart and become worse by 0.5 % an image, from 1 % on.
struct Asked {
    int image = 0;
    GateReason reason = GateReason::none;
};
Asked ask_between_frames(Gate gate, int interval) {
    for (int k = 1; k <= 40; ++k) {
        const int after = (k - 1) % interval;
        if (gate.wants_light(expecting(0.5 + 0.5 * (k - after), 100, 0.2), true,
                             {.now = after == 0, .next_in = interval - after}))
            return {k, gate.reason()};
    }
    return {};
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
    // A map is carried while the light wakes up again: its error hardly grows any more.
    for (int i = 0; i <= 3; ++i)
        CHECK(gate.wants_light(expecting(1 + 0.1 * i, 100, 0.2)));
    gate.measured();
    CHECK_FALSE(gate.keeps_light());
    CHECK_FALSE(gate.wants_light(expecting(1, 100, 0.2)));
}

TEST_CASE("right after a measurement the gate expects the error to grow as before it", "[core]") {
    Gate gate = gate_after_a_cycle({.target_mre = 2.6}, 3);
    REQUIRE_FALSE(gate.keeps_light()); // 1 + 3 x 0.5 %
    SECTION("more where carrying the map has added more") {
        // 1.2 + 3 x 0.5 x (1.2 - 0.2) / (1 - 0.2) %
        CHECK(gate.wants_light(expecting(1.2, 100, 0.2)));
        CHECK(gate.reason() == GateReason::error);
    }
    SECTION("until a second map shows how it grows now") {
        CHECK_FALSE(gate.wants_light(expecting(1, 100, 0.2)));
        CHECK_FALSE(gate.wants_light(expecting(1.3, 100, 0.2)));
        CHECK(gate.wants_light(expecting(1.9, 100, 0.2)));
    }
}

TEST_CASE("between distant frames the gate lights so that a measurement comes with a frame",
          "[core]") {
    constexpr int latency = 3;
    SECTION("with the next one, if that would miss the target") {
        // Frames: image 1, of 1 %, and image 9, of 5 %.
        const Asked asked = ask_between_frames(gate_after_a_cycle({.target_mre = 3}, latency), 8);
        CHECK(asked.image == 9 - latency);
        CHECK(asked.reason == GateReason::error);
    }
    SECTION("else with the one after it") {
        const Asked asked = ask_between_frames(gate_after_a_cycle({.target_mre = 6}, latency), 8);
        CHECK(asked.image == 17 - latency);
    }
    SECTION("or where that saves more than it costs") {
        Gate gate = gate_after_a_cycle({.target_mre = 6}, latency);
        gate.set_policy({.target_mre = 6, .measurement_price = 1.4});
        const Asked asked = ask_between_frames(gate, 8);
        CHECK(asked.image == 9 - latency); // 9 x (5^2 - 1^2) > 1.4 x 6^2
        CHECK(asked.reason == GateReason::saving);
    }
    SECTION("but does not wait when a frame has missed it already") {
        Gate gate = gate_after_a_cycle({.target_mre = 6}, latency);
        CHECK_FALSE(gate.wants_light(expecting(1, 100, 0.2), true, {.next_in = 8}));
        CHECK(gate.wants_light(expecting(7, 100, 0.2), true, {.next_in = 8}));
    }
    SECTION("and does not wait when the motion is lost") {
        Gate gate = gate_after_a_cycle({.target_mre = 6}, latency);
        CHECK(gate.wants_light(bad, true, {.now = false, .next_in = 7}));
    }
}

TEST_CASE("the gate looks ahead at each frame if they are nearer than the wake latency", "[core]") {
    // Image 3 is wrong by 2 %, and would be by 3.5 % when a measurement arrives.
    const Asked asked = ask_between_frames(gate_after_a_cycle({.target_mre = 3.2}, 3), 2);
    CHECK(asked.image == 3);
    CHECK(asked.reason == GateReason::error);
}

TEST_CASE("without wake latency the gate lights only at images that have a frame", "[core]") {
    const Asked asked = ask_between_frames(gate_after_a_cycle({.target_mre = 3}, 0), 8);
    CHECK(asked.image == 9);
}

TEST_CASE("a TOF camera that wakes within the interval of frames does not stay lit", "[core]") {
    CHECK(gate_after_a_cycle({.target_mre = 2.4}, 3, 0.2, 2).keeps_light());
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 2.4}, 3, 0.2, 3).keeps_light());
    CHECK_FALSE(gate_after_a_cycle({.target_mre = 2.4}, 3, 0.2, 10).keeps_light());
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
