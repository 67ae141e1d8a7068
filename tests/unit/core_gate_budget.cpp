// SPDX-License-Identifier: Apache-2.0
#include "tests/catch.hpp"
#include "tests/gates.hpp"

#include <algorithm>
#include <random>

using namespace afterglow;
using namespace afterglow::testing;

TEST_CASE("the gate's duty cycle stays within its budget in the long run", "[core]") {
    const double budget = GENERATE(2.0, 5.0, 20.0, 50.0);
    const int latency = GENERATE(0, 1, 4, 10);
    const int demand = GENERATE(0, 1, 2);
    INFO(budget << " %, latency " << latency << ", demand " << demand);
    constexpr int frames = 20'000;
    const GatePolicy policy{
        .target_mre = 1.35, .measurement_price = 0, .duty_cycle_budget = budget};
    Gate gate(policy);
    std::mt19937 random(7);
    const auto lit = lit_images(gate, frames, latency, [&](int) {
        switch (demand) {
        case 0:
            return bad; // always
        case 1:
            return random() % 4 == 0 ? bad : expecting(0.1);
        default:
            return expecting(0.1 * static_cast<double>(random() % 20), 100, 0.1);
        }
    });
    const auto used = std::count(lit.begin(), lit.end(), true);
    // Beyond its share only what may be saved up, and a wake that had begun.
    CHECK(static_cast<double>(used) <= budget / 100 * frames + policy.budget_burst + 1 + latency);
    CHECK(static_cast<double>(used) > 0.5 * budget / 100 * frames / (demand == 0 ? 1 : 5));
}

TEST_CASE("the gate with an exhausted duty-cycle budget lights in bursts", "[core]") {
    const GatePolicy policy{.duty_cycle_budget = 10, .budget_burst = 8};
    Gate gate(policy);
    const auto lit = lit_images(gate, 2'000, 0, [](int) { return bad; });
    int changes = 0;
    for (std::size_t k = 1; k < lit.size(); ++k)
        changes += lit[k] != lit[k - 1];
    const auto used = std::count(lit.begin(), lit.end(), true);
    // Half the burst is saved up before each turn: four frames in a row, on and off again.
    CHECK(changes <= 2 * (used / 3 + 1));
}

TEST_CASE("the gate saves no more unused duty-cycle budget than one burst", "[core]") {
    const GatePolicy policy{
        .longest_interval_frames = 100'000, .duty_cycle_budget = 10, .budget_burst = 6};
    Gate gate = measured_gate(policy);
    for (int k = 0; k < 1'000; ++k)
        REQUIRE_FALSE(gate.wants_light(expecting(0.1)));
    int row = 0;
    while (row < 100 && gate.wants_light(bad)) {
        gate.measured();
        ++row;
    }
    CHECK(row >= 5);
    CHECK(row <= 7);
}

TEST_CASE("a pause gives the gate no new budget") {
    const double budget = GENERATE(1.0, 10.0);
    Gate gate({.duty_cycle_budget = budget});
    int lit = 0;
    for (int pause = 0; pause < 1'000; ++pause) {
        gate.restart();
        for (int k = 0; k < 3; ++k)
            if (gate.wants_light(bad)) {
                ++lit;
                gate.measured();
            }
    }
    CHECK(lit <= budget / 100 * 3'000 + GatePolicy{}.budget_burst + 1);
    CHECK(lit > 0.5 * budget / 100 * 3'000);
}

TEST_CASE("the gate's duty-cycle budget bounds every mode") {
    const auto mode = GENERATE(GateMode::always_on, GateMode::interval, GateMode::automatic);
    const GatePolicy policy{.mode = mode, .interval_frames = 2, .duty_cycle_budget = 5};
    Gate gate(policy);
    int refused = 0;
    const auto lit = lit_images(gate, 2'000, 0, [&](int) {
        refused += gate.budget_spent();
        return bad;
    });
    CHECK(std::count(lit.begin(), lit.end(), true) <= 0.05 * 2'000 + policy.budget_burst + 1);
    CHECK(refused > 800);
}

TEST_CASE("without a budget the gate refuses nothing, whatever the burst") {
    Gate gate({.mode = GateMode::always_on, .budget_burst = 1});
    for (int k = 0; k < 100; ++k) {
        REQUIRE(gate.wants_light(good));
        gate.measured();
    }
}

TEST_CASE("a wake that has begun is not cut off by the budget") {
    Gate gate({.duty_cycle_budget = 0.01, .budget_burst = 1});
    for (int k = 0; k < 50; ++k)
        CHECK(gate.wants_light(bad)); // a camera that takes its time
    gate.measured();
    CHECK_FALSE(gate.wants_light(bad));
}
