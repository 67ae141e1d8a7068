// SPDX-License-Identifier: Apache-2.0
#include "ipc/power_model.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

TEST_CASE("the power model gives the paper's 23 % to 73 % at a duty cycle of 15 %", "[core]") {
    const auto saving = [](double tof_w) {
        PowerModel model;
        model.tof_w = tof_w;
        return model.saving(0.15);
    };
    CHECK(saving(1) == Approx(0.23).margin(0.01));
    CHECK(saving(5) == Approx(0.73).margin(0.01));
}

TEST_CASE("the power model's limits are the TOF camera alone and the processor alone", "[core]") {
    const PowerModel model;
    CHECK(model.system_w(1) == Approx(5.19)); // P_TOF + P_I
    CHECK(model.system_w(0) == Approx(0.69)); // P_C + P_M
    CHECK(model.saving(1) < 0);               // always lit, the idle processor comes on top
}
