// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/film.hpp"
#include "tests/gates.hpp"

#include <random>

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("the gate's modes convert to their names and back", "[core]") {
    for (const char *name : {"auto", "always-on", "interval", "off"})
        CHECK(to_string(*gate_mode_from_string(name)) == name);
    CHECK_FALSE(gate_mode_from_string("automatic"));
    CHECK_FALSE(gate_mode_from_string(""));
}

TEST_CASE("the gate asks for the first frame in every mode except off", "[core]") {
    CHECK(Gate({.mode = GateMode::automatic}).wants_light(good));
    CHECK(Gate({.mode = GateMode::always_on}).wants_light(good));
    CHECK(Gate({.mode = GateMode::interval}).wants_light(good));
    CHECK_FALSE(Gate({.mode = GateMode::off}).wants_light(bad));
}

TEST_CASE("the gate in mode auto passes on the estimator's request until measured", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::automatic});
    CHECK_FALSE(gate.wants_light(good));
    CHECK(gate.wants_light(bad));
    CHECK(gate.wants_light(good));
    gate.measured();
    CHECK_FALSE(gate.wants_light(good));
}

TEST_CASE("the gate adds the error of pixels where something moved to the expected error",
          "[core]") {
    const GatePolicy policy{.target_mre = 2, .measurement_price = 0};
    Estimate moved = expecting(1.5);
    Gate gate = measured_gate(policy);
    CHECK_FALSE(gate.wants_light(moved));
    moved.moved_mre = 0.6f;
    CHECK(gate.wants_light(moved));
    CHECK(gate.reason() == GateReason::error);
    gate = measured_gate(policy);
    moved.expected_mre = -1; // not predicted
    CHECK_FALSE(gate.wants_light(moved));
}

TEST_CASE("the gate in mode interval asks at fixed intervals whatever the estimate", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::interval, .interval_frames = 3});
    CHECK_FALSE(gate.wants_light(bad));
    CHECK_FALSE(gate.wants_light(bad));
    CHECK(gate.wants_light(bad));
    gate.measured();
    CHECK_FALSE(gate.wants_light(good));
}

TEST_CASE("the gate in mode always-on keeps the light on", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::always_on});
    CHECK(gate.keeps_light());
    CHECK(gate.wants_light(good));
    gate.set_policy({.mode = GateMode::off});
    CHECK_FALSE(gate.keeps_light());
    CHECK_FALSE(gate.wants_light(bad));
}

TEST_CASE("the gate lights when the expected error exceeds the target", "[core]") {
    Gate gate = measured_gate({.target_mre = 1.2});
    CHECK_FALSE(gate.wants_light(expecting(1.19)));
    CHECK(gate.wants_light(expecting(1.21)));
}

TEST_CASE("the gate lights when a measurement saves more squared error than it costs", "[core]") {
    // Errors 1, 1.1, 1.2, ...: n (e_n^2 - e_1^2) - sum_i (e_i^2 - e_1^2) first reaches p at n.
    const auto expected = [](int price_frames) {
        double sum = 0;
        for (int n = 1;; ++n) {
            const double e = 0.9 + 0.1 * n;
            sum += e * e - 1;
            if (n * (e * e - 1) - sum >= price_frames * 9)
                return n;
        }
    };
    const auto growing = [](int k) { return expecting(0.9f + 0.1f * static_cast<float>(k)); };
    for (const int price : {1, 2, 4}) {
        Gate gate = measured_gate({.target_mre = 3, .measurement_price = double(price)});
        CHECK(first_lit(gate, 20, growing) == expected(price));
    }
    Gate target_alone = measured_gate({.target_mre = 3, .measurement_price = 0});
    CHECK(first_lit(target_alone, 40, growing) == 22);
    Gate constant = measured_gate({.target_mre = 3, .longest_interval_frames = 1000});
    CHECK(first_lit(constant, 200, [](int) { return expecting(2.9f); }) == 0);
}

TEST_CASE("a lost image that gets no light changes nothing of what the gate knows of errors",
          "[core]") {
    const auto growing = [](int image) { return expecting(0.5 + 0.06 * image); };
    GatePolicy policy;
    policy.shortest_interval_frames = 6; // so that a lost image is not lit
    Gate undisturbed = measured_gate(policy);
    const int lit = first_lit(undisturbed, 40, growing);
    REQUIRE(lit > 6);
    const auto lost = GENERATE(std::vector{1}, std::vector{1, 2}, std::vector{3}, std::vector{5});
    Gate gate = measured_gate(policy);
    const int lit_with_lost = first_lit(gate, 40, [&](int image) {
        if (std::ranges::find(lost, image) == lost.end())
            return growing(image);
        Estimate estimate = bad;
        estimate.expected_mre = estimate.independent_mre = 100;
        estimate.relative_coverage = 0;
        return estimate;
    });
    CAPTURE(lost);
    CHECK(std::abs(lit_with_lost - lit) <= static_cast<int>(lost.size()));
}

TEST_CASE("the gate does not light to save an error that near views have in common", "[core]") {
    // The expected error grows, but only because the errors become less correlated.
    const auto less_correlated = [](int k) {
        Estimate estimate = expecting(1 + 0.1 * k);
        estimate.independent_mre = 2.5;
        return estimate;
    };
    Gate gate = measured_gate({.target_mre = 3, .longest_interval_frames = 1000});
    CHECK(first_lit(gate, 200, less_correlated) == 21); // the target is missed all the same
    CHECK(gate.reason() == GateReason::error);
    // What carrying adds can be saved, whatever the expected error does.
    const auto carried = [](int k) {
        Estimate estimate = expecting(2);
        estimate.independent_mre = static_cast<float>(2 + 0.1 * k);
        return estimate;
    };
    Gate saving = measured_gate({.target_mre = 3, .longest_interval_frames = 1000});
    CHECK(first_lit(saving, 200, carried) > 0);
    CHECK(saving.reason() == GateReason::saving);
}

TEST_CASE("the gate does not light when a measurement would hardly improve the error", "[core]") {
    Gate gate = measured_gate({.target_mre = 1.2, .worthwhile = 75});
    CHECK_FALSE(gate.wants_light(expecting(2.0, 100, 1.6)));
    CHECK(gate.wants_light(expecting(2.0, 100, 1.4)));
}

TEST_CASE("a sensor whose own noise misses the target is not lit for every image", "[core]") {
    Film scene = film_room(160, 120, 20);
    std::mt19937 random(1);
    std::normal_distribution<double> noise(1, 0.03);
    for (DepthMap &depth : scene.depth)
        for (std::uint16_t &z : depth.pixels())
            z = static_cast<std::uint16_t>(std::lround(z * noise(random)));
    EstimatorOptions options;
    options.keyframe.surface.noise.linear = 0.03f;
    const auto measured = [&](double worthwhile) {
        Viewer viewer(scene, options);
        Gate gate({.worthwhile = worthwhile});
        int count = 0;
        for (int k = 0; k < 20; ++k)
            if (gate.wants_light(viewer.track(k))) {
                viewer.measure(k);
                gate.measured();
                ++count;
            }
        return count;
    };
    CHECK(measured(100) == 20);
    CHECK(measured(75) < 10);
}

TEST_CASE("the gate lights when coverage falls below its floor", "[core]") {
    Gate gate = measured_gate({.coverage_floor = 70});
    CHECK_FALSE(gate.wants_light(expecting(0.1, 71)));
    CHECK(gate.wants_light(expecting(0.1, 69)));
}

TEST_CASE("the gate lights an estimate without expected error only on its request", "[core]") {
    Gate gate = measured_gate({});
    Estimate silent = expecting(-1, 0);
    CHECK_FALSE(gate.wants_light(silent));
    silent.wants_measurement = true;
    CHECK(gate.wants_light(silent));
}

TEST_CASE("the gate respects the shortest and longest interval between measurements", "[core]") {
    Gate gate = measured_gate({.shortest_interval_frames = 4, .longest_interval_frames = 9});
    CHECK(first_lit(gate, 100, [](int) { return bad; }) == 4);
    gate.measured();
    CHECK(first_lit(gate, 100, [](int) { return expecting(0.1); }) == 9);
}

TEST_CASE("a requested measurement is made once, in every mode but off") {
    const auto mode = GENERATE(GateMode::automatic, GateMode::interval);
    Gate gate = measured_gate({.mode = mode, .interval_frames = 100});
    CHECK_FALSE(gate.wants_light(good));
    gate.request_measurement();
    CHECK(gate.wants_light(good));
    CHECK(gate.reason() == GateReason::requested);
    CHECK(gate.wants_light(good)); // until it comes
    gate.measured();
    CHECK_FALSE(gate.wants_light(good));
    gate.set_policy({.mode = GateMode::off});
    gate.request_measurement();
    CHECK_FALSE(gate.wants_light(good));
}

TEST_CASE("no map gets older than allowed") {
    const int latency = GENERATE(0, 2);
    Gate gate = measured_gate({.longest_age_ms = 200}, latency);
    const int lit = first_lit(gate, 100, [](int k) {
        Estimate e = expecting(0.1);
        e.age_frames = static_cast<std::uint32_t>(k);
        e.age_ns = k * 33'000'000LL;
        return e;
    });
    CHECK(gate.reason() == GateReason::age);
    CHECK((lit - 1) * 33 <= 200);           // the last frame in the dark
    CHECK((lit + latency) * 33 > 200);      // and no earlier than that needs
    CHECK((lit + latency - 1) * 33 <= 200); // nor any frame until the measurement arrives
}

TEST_CASE("a TOF camera that cannot be lit costs the gate no budget and no latency") {
    Gate gate = measured_gate({.duty_cycle_budget = 10});
    for (int k = 0; k < 100; ++k)
        REQUIRE_FALSE(gate.wants_light(bad, false));
    CHECK(gate.wants_light(bad));
    gate.measured();
    CHECK(gate.wake_latency_frames() == 0);
}

TEST_CASE("the gate says why it lights") {
    const GatePolicy policy{.target_mre = 1.2, .measurement_price = 0, .coverage_floor = 80};
    Gate gate(policy);
    gate.wants_light(bad);
    CHECK(gate.reason() == GateReason::first);
    const auto [estimate, reason] =
        GENERATE(table<Estimate, GateReason>({{bad, GateReason::lost},
                                              {expecting(1.3), GateReason::error},
                                              {expecting(0.1, 70), GateReason::coverage},
                                              {expecting(0.1), GateReason::none}}));
    gate.measured();
    CHECK(gate.wants_light(estimate) == (reason != GateReason::none));
    CHECK(gate.reason() == reason);
}
