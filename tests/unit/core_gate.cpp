// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"
#include "tests/catch.hpp"
#include "tests/film.hpp"

#include <algorithm>
#include <random>
#include <vector>

using namespace afterglow;
using namespace afterglow::testing;

namespace {

const Estimate good{.source = FrameSource::estimated};
const Estimate bad{.source = FrameSource::none, .wants_measurement = true};

/// An estimate that predicts its error and coverage, percent.
Estimate expecting(double mre, double coverage = 100, double fresh_mre = 0) {
    Estimate e{.source = FrameSource::estimated};
    e.expected_mre = static_cast<float>(mre);
    e.fresh_mre = static_cast<float>(fresh_mre);
    e.relative_coverage = static_cast<float>(coverage);
    return e;
}

/// A gate whose first measurement took `latency` images to arrive.
Gate measured_gate(const GatePolicy &policy, int latency = 0) {
    Gate gate(policy);
    for (int i = 0; i <= latency; ++i)
        gate.wants_light(bad);
    gate.measured();
    return gate;
}

/// The number of the image, from 1, for which the gate first asks for light; 0: never in `most`.
template <class Estimates>
int first_lit(Gate &gate, int most, Estimates &&estimate) {
    for (int k = 1; k <= most; ++k)
        if (gate.wants_light(estimate(k)))
            return k;
    return 0;
}

/// The images for which a gate asks for light, of `frames`; a measurement arrives with the last of
/// `1 + latency` lit images in a row.
template <class Estimates>
std::vector<bool> lit_images(Gate &gate, int frames, int latency, Estimates &&estimate) {
    std::vector<bool> lit;
    int row = 0;
    for (int k = 0; k < frames; ++k) {
        lit.push_back(gate.wants_light(estimate(k)));
        row = lit.back() ? row + 1 : 0;
        if (row == 1 + latency) {
            gate.measured();
            row = 0;
        }
    }
    return lit;
}

} // namespace

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

TEST_CASE("a slow wake costs light and no accuracy: measurements arrive as often", "[core]") {
    const auto growing = [](int k) { return expecting(0.9f + 0.1f * static_cast<float>(k)); };
    Gate quick = measured_gate({.target_mre = 5});
    Gate slow = measured_gate({.target_mre = 5}, 3);
    const int arrival = first_lit(slow, 50, growing) + 3;
    CHECK(std::abs(arrival - first_lit(quick, 50, growing)) <= 1);
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
