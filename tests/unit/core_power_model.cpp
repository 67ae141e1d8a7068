// SPDX-License-Identifier: Apache-2.0
#include "core/power_model.hpp"
#include "tests/catch.hpp"

using namespace afterglow;

TEST_CASE("the power model charges light by the duty cycle and cores by their CPU time", "[ipc]") {
    const PowerModel model{.tof_w = 4, .idle_w = 0.5, .core_w = 2};
    CHECK(model.system_w(0, 0) == Approx(0.5));
    CHECK(model.system_w(0.25, 0) == Approx(1.5));
    CHECK(model.system_w(0.25, 1.5) == Approx(4.5));
}

TEST_CASE("four busy cores of the power model take what the paper's board takes", "[ipc]") {
    CHECK(PowerModel().system_w(0, 4) == Approx(0.63 + 0.06));
    CHECK(PowerModel().system_w(0, 0) == Approx(0.16 + 0.03));
}
