// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

namespace {

const Estimate good{.source = FrameSource::estimated};
const Estimate bad{.source = FrameSource::none, .wants_measurement = true};

Gate measured_gate(GatePolicy policy) {
    Gate gate(policy);
    gate.wants_light(bad);
    gate.measured();
    return gate;
}

} // namespace

TEST_CASE("the gate's modes have the names shown to people", "[core]") {
    for (const char *name : {"auto", "always-on", "interval", "off"})
        CHECK(to_string(*gate_mode_from_string(name)) == name);
    CHECK_FALSE(gate_mode_from_string("automatic"));
    CHECK_FALSE(gate_mode_from_string(""));
}

TEST_CASE("the first frame is measured, but in mode off", "[core]") {
    CHECK(Gate({.mode = GateMode::automatic}).wants_light(good));
    CHECK(Gate({.mode = GateMode::always_on}).wants_light(good));
    CHECK(Gate({.mode = GateMode::interval}).wants_light(good));
    CHECK_FALSE(Gate({.mode = GateMode::off}).wants_light(bad));
}

TEST_CASE("an automatic gate asks when the estimator does, until it is served", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::automatic});
    CHECK_FALSE(gate.wants_light(good));
    CHECK(gate.wants_light(bad));
    CHECK(gate.wants_light(good));
    gate.measured();
    CHECK_FALSE(gate.wants_light(good));
}

TEST_CASE("an interval gate asks every so many frames, whatever the estimate", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::interval, .interval_frames = 3});
    CHECK_FALSE(gate.wants_light(bad));
    CHECK_FALSE(gate.wants_light(bad));
    CHECK(gate.wants_light(bad));
    gate.measured();
    CHECK_FALSE(gate.wants_light(good));
}

TEST_CASE("an always-on gate keeps its light", "[core]") {
    Gate gate = measured_gate({.mode = GateMode::always_on});
    CHECK(gate.keeps_light());
    CHECK(gate.wants_light(good));
    gate.set_mode(GateMode::off);
    CHECK_FALSE(gate.keeps_light());
    CHECK_FALSE(gate.wants_light(bad));
}
