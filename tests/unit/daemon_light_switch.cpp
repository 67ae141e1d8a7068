// SPDX-License-Identifier: Apache-2.0
#include "daemon/light_switch.hpp"
#include "tests/captured_stderr.hpp"
#include "tests/catch.hpp"
#include "tests/wait_until.hpp"

#include <atomic>
#include <chrono>
#include <memory>
#include <semaphore>

using namespace afterglow;
using namespace std::chrono_literals;

namespace {

std::int64_t now_ns() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A light whose every switching waits until the test lets it happen, or makes it fail.
struct SlowLamp {
    std::counting_semaphore<> begun{0};
    std::counting_semaphore<> may_end{0};
    std::atomic<bool> fails = false;
    std::atomic<bool> obeys_anyway = false; ///< although it says that it fails
    std::atomic<bool> on = false;
    std::atomic<int> switched = 0;
    std::atomic<bool> destroyed = false;

    void let() {
        begun.acquire();
        may_end.release();
    }
};

class SlowLight final : public Illuminator {
public:
    explicit SlowLight(SlowLamp &lamp) : lamp_(lamp) {}
    ~SlowLight() override {
        lamp_.on = false;
        lamp_.destroyed = true;
    }
    Status set(bool lit) override {
        lamp_.begun.release();
        lamp_.may_end.acquire();
        ++lamp_.switched;
        if (!lamp_.fails || lamp_.obeys_anyway)
            lamp_.on = lit;
        return lamp_.fails ? Status(Error{"the lamp is stuck", 0}) : ok();
    }
    bool lit() const override { return lamp_.on; }

private:
    SlowLamp &lamp_;
};

template <class Condition>
void expect_soon(Condition condition) {
    REQUIRE(wait_until(condition));
}

} // namespace

TEST_CASE("the light switch works without blocking its caller", "[tsan]") {
    SlowLamp lamp;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    CHECK_FALSE(light.lit());
    CHECK(light.set(true)); // returns, though the lamp does not
    CHECK(light.lit());
    lamp.let();
    expect_soon([&] { return lamp.on.load(); });
    CHECK(light.set(false));
    CHECK_FALSE(light.lit());
    CHECK(lamp.on);
    lamp.let();
    expect_soon([&] { return !lamp.on; });
}

TEST_CASE("the light switch counts frames as lit from the on order to the end of switching off",
          "[tsan]") {
    SlowLamp lamp;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    const std::int64_t before = now_ns();
    CHECK(light.set(true));
    const std::int64_t ordered = now_ns();
    lamp.let();
    expect_soon([&] { return lamp.on.load(); });
    CHECK(light.set(false));
    lamp.begun.acquire();
    const std::int64_t darkening = now_ns();
    CHECK(light.was_lit(darkening)); // it may still be lit
    lamp.may_end.release();
    expect_soon([&] { return !light.was_lit(now_ns()); });
    CHECK_FALSE(light.was_lit(before));
    CHECK(light.was_lit(ordered));
    CHECK(light.was_lit(darkening));
}

TEST_CASE("the light switch reports a failed order at the next one and accepts a retry", "[tsan]") {
    SlowLamp lamp;
    lamp.may_end.release(1000); // never waits, however often the switch tries again
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    lamp.fails = true;
    CHECK(light.set(true));
    expect_soon([&] { return !light.lit(); });
    const Status told = light.set(true);
    REQUIRE_FALSE(told);
    CHECK(told.error().message == "the lamp is stuck");
    CHECK_FALSE(light.was_lit(now_ns()));
    lamp.fails = false;
    CHECK(light.set(true));
    expect_soon([&] { return lamp.on.load(); });

    lamp.fails = true;
    CHECK(light.set(false));
    expect_soon([&] { return light.lit(); });
    CHECK_FALSE(light.set(false));
    CHECK(light.was_lit(now_ns())); // as far as anybody knows
    lamp.fails = false;
    CHECK(light.set(false));
    expect_soon([&] { return !light.was_lit(now_ns()); });
}

TEST_CASE("a light that goes on and says that it failed is put out again", "[tsan]") {
    SlowLamp lamp;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    lamp.fails = lamp.obeys_anyway = true;
    CHECK(light.set(true));
    lamp.let();
    REQUIRE(wait_until([&] { return lamp.begun.try_acquire(); })); // another order
    CHECK(lamp.on);
    lamp.fails = false;
    lamp.may_end.release();
    expect_soon([&] { return !lamp.on; });
    expect_soon([&] { return !light.lit(); });
    CHECK_FALSE(light.set(true)); // tells why
}

TEST_CASE("the light switch drops an order that its opposite overtakes", "[tsan]") {
    SlowLamp lamp;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    CHECK(light.set(true));
    lamp.begun.acquire(); // it is being lit
    CHECK(light.set(false));
    CHECK(light.set(true));
    CHECK(light.set(false));
    lamp.may_end.release();
    lamp.let(); // the last order
    expect_soon([&] { return !light.was_lit(now_ns()); });
    CHECK_FALSE(lamp.on);
    CHECK(lamp.switched == 2);
}

TEST_CASE("the light switch leaves the light off when destroyed", "[tsan]") {
    SlowLamp lamp;
    {
        LightSwitch light(std::make_unique<SlowLight>(lamp));
        CHECK(light.set(true));
        lamp.let();
        expect_soon([&] { return lamp.on.load(); });
    }
    CHECK_FALSE(lamp.on);
    CHECK(lamp.destroyed);
}

TEST_CASE("a light that fails to go dark is tried again until it obeys, though nobody asks") {
    SlowLamp lamp;
    lamp.may_end.release(1000);
    const CapturedStderr captured;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    CHECK(light.set(true));
    expect_soon([&] { return lamp.on.load(); });
    lamp.fails = true;
    CHECK(light.set(false));
    expect_soon([&] { return lamp.switched >= 4; });
    CHECK(light.was_lit(now_ns()));
    CHECK_FALSE(light.set(false)); // as the frame loop does when it stops: takes the error
    lamp.fails = false;
    expect_soon([&] { return !lamp.on; });
    expect_soon([&] { return !light.lit(); });
    CHECK_FALSE(light.was_lit(now_ns()));
    const std::string text = captured.text();
    CHECK(text.find("may still be lit") == text.rfind("may still be lit"));
    CHECK(text.find("the illuminator is dark\n") != std::string::npos);
    // Then it works as before.
    CHECK(light.set(true));
    expect_soon([&] { return lamp.on.load(); });
}

TEST_CASE("a light that fails to go on, and then to go off, is put out as soon as it obeys") {
    SlowLamp lamp;
    const CapturedStderr captured;
    LightSwitch light(std::make_unique<SlowLight>(lamp));
    lamp.fails = lamp.obeys_anyway = true; // it is lit, and says that it is not
    CHECK(light.set(true));
    lamp.begun.acquire();
    lamp.may_end.release();
    lamp.begun.acquire(); // to go off
    CHECK(lamp.on);
    lamp.obeys_anyway = false;
    lamp.may_end.release();
    lamp.begun.acquire(); // again
    CHECK(lamp.on);
    lamp.fails = false;
    lamp.may_end.release();
    expect_soon([&] { return !lamp.on; });
    CHECK(captured.text().find("the illuminator may still be lit: the lamp is stuck\n") !=
          std::string::npos);
}

TEST_CASE("a light that fails to go dark while nobody asks is logged, once for each failure") {
    SlowLamp lamp;
    const CapturedStderr captured;
    {
        LightSwitch light(std::make_unique<SlowLight>(lamp));
        CHECK(light.set(true));
        lamp.let();
        expect_soon([&] { return lamp.on.load(); });
        lamp.fails = true;
        CHECK(light.set(false));
        lamp.let();
        expect_soon([&] { return lamp.switched == 2; });
        expect_soon([&] { return !captured.text().empty(); });
        expect_soon([&] { return !light.set(false); }); // takes the error
        CHECK(light.set(false));
        lamp.let();
        expect_soon([&] { return lamp.switched >= 3; });
        lamp.may_end.release(1000); // the switch may have begun to try again
    }
    const std::string text = captured.text();
    const std::string line = "the illuminator may still be lit: the lamp is stuck\n";
    CHECK(text.find(line) != std::string::npos);
    CHECK(text.find(line) == text.rfind(line));
}
