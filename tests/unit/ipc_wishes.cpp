// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/wishes.hpp"
#include "tests/catch.hpp"

#include <list>

using namespace afterglow;

namespace {

Wish hold(GateMode mode) {
    return {.kind = Wish::Kind::mode, .mode = mode};
}
Wish accuracy(double error, std::uint32_t age_ms = 0) {
    return {.max_relative_error = error, .max_age_ms = age_ms};
}

GatePolicy rules(const GatePolicy &own, const std::list<Wish> &wishes) {
    std::list<const Wish *> all;
    for (const Wish &wish : wishes)
        all.push_back(&wish);
    return strictest(own, all);
}

/// Both cameras run, and the newest frame is estimated.
Situation running(GateMode mode = GateMode::automatic, float error = 1, std::int64_t age_ns = 0) {
    Situation situation{.mode = mode, .cameras = {CameraState::running, CameraState::running}};
    situation.frame.emplace();
    situation.frame->frame.source = AFTERGLOW_ESTIMATED;
    situation.frame->frame.expected_mre = error;
    situation.frame->frame.age_ns = age_ns;
    return situation;
}

Situation with_budget_spent(Situation situation) {
    situation.frame->frame.flags = AFTERGLOW_FRAME_BUDGET_SPENT;
    return situation;
}

} // namespace

TEST_CASE("without requests the daemon's own policy rules") {
    const GatePolicy own{.mode = GateMode::interval, .interval_frames = 7};
    CHECK(rules(own, {}) == own);
}

TEST_CASE("of several modes the strictest rules, whoever wants it") {
    CHECK(rules({}, {hold(GateMode::interval)}).mode == GateMode::interval);
    CHECK(rules({}, {hold(GateMode::interval), hold(GateMode::always_on)}).mode ==
          GateMode::always_on);
    CHECK(rules({}, {hold(GateMode::off), hold(GateMode::always_on)}).mode == GateMode::off);
    CHECK(rules({.mode = GateMode::off}, {hold(GateMode::always_on)}).mode == GateMode::off);
    CHECK(rules({.mode = GateMode::always_on}, {hold(GateMode::automatic)}).mode ==
          GateMode::always_on);
}

TEST_CASE("of several accuracies the least error and the least age rule") {
    const GatePolicy policy = rules(
        {.target_mre = 2}, {accuracy(1.5), accuracy(0, 300), accuracy(3, 200), accuracy(0.5, 900)});
    CHECK(policy.target_mre == 0.5);
    CHECK(policy.longest_age_ms == 200);
    CHECK(rules({.target_mre = 2}, {accuracy(3)}).target_mre == 2); // the daemon's takes part
}

TEST_CASE("requests never change the budget") {
    const GatePolicy own{.duty_cycle_budget = 3, .budget_burst = 4};
    const GatePolicy policy = rules(own, {hold(GateMode::always_on), accuracy(0.01, 1)});
    CHECK(policy.duty_cycle_budget == 3);
    CHECK(policy.budget_burst == 4);
}

TEST_CASE("a held mode is kept when it rules and the budget allows its light") {
    CHECK(obstacle_of(hold(GateMode::always_on), running(GateMode::always_on)) == Obstacle::none);
    CHECK(obstacle_of(hold(GateMode::interval), running(GateMode::always_on)) ==
          Obstacle::overruled);
    CHECK(obstacle_of(hold(GateMode::always_on), running(GateMode::off)) == Obstacle::dark);
    CHECK(obstacle_of(hold(GateMode::always_on), with_budget_spent(running(GateMode::always_on))) ==
          Obstacle::budget);
    CHECK(obstacle_of(hold(GateMode::off), running(GateMode::off)) == Obstacle::none);
}

TEST_CASE("darkness is kept also while the cameras sleep, light is not") {
    Situation asleep{.mode = GateMode::off, .cameras = {CameraState::asleep, CameraState::asleep}};
    CHECK(obstacle_of(hold(GateMode::off), asleep) == Obstacle::none);
    asleep.mode = GateMode::always_on;
    CHECK(obstacle_of(hold(GateMode::always_on), asleep) == Obstacle::asleep);
    CHECK(obstacle_of(accuracy(1), asleep) == Obstacle::asleep);
}

TEST_CASE("an accuracy is kept when the newest frame has it") {
    CHECK(obstacle_of(accuracy(1), running(GateMode::automatic, 0.9F)) == Obstacle::none);
    CHECK(obstacle_of(accuracy(1), running(GateMode::automatic, 1.1F)) == Obstacle::unhelpful);
    CHECK(obstacle_of(accuracy(1), running(GateMode::automatic, -1)) == Obstacle::unhelpful);
    CHECK(obstacle_of(accuracy(0, 100), running(GateMode::automatic, -1, 100'000'000)) ==
          Obstacle::none);
    CHECK(obstacle_of(accuracy(0, 100), running(GateMode::automatic, 0, 100'000'001)) ==
          Obstacle::unhelpful);
    // Also in other modes, and with a budget that others have spent.
    CHECK(obstacle_of(accuracy(1), running(GateMode::off, 0.9F)) == Obstacle::none);
    CHECK(obstacle_of(accuracy(1), with_budget_spent(running(GateMode::automatic, 0.9F))) ==
          Obstacle::none);
}

TEST_CASE("an accuracy that is missed says what prevents it") {
    const Wish wish = accuracy(1);
    CHECK(obstacle_of(wish, running(GateMode::off, 2)) == Obstacle::dark);
    CHECK(obstacle_of(wish, running(GateMode::interval, 2)) == Obstacle::interval);
    CHECK(obstacle_of(wish, with_budget_spent(running(GateMode::automatic, 2))) ==
          Obstacle::budget);

    Situation situation = running(GateMode::automatic, 2);
    situation.cameras.tof = CameraState::lost;
    CHECK(obstacle_of(wish, situation) == Obstacle::tof_lost);
    situation.cameras.color = CameraState::lost;
    CHECK(obstacle_of(wish, situation) == Obstacle::color_lost);

    situation = running(GateMode::automatic, 2);
    situation.frame->reason = GateReason::error; // a measurement is on its way
    CHECK(obstacle_of(wish, situation) == Obstacle::none);
    situation.frame->frame.source = AFTERGLOW_MEASURED;
    CHECK(obstacle_of(wish, situation) == Obstacle::precision);
}

TEST_CASE("every obstacle has a sentence") {
    CHECK(to_string(Obstacle::none).empty());
    for (const Obstacle obstacle : {Obstacle::overruled, Obstacle::dark, Obstacle::asleep,
                                    Obstacle::color_lost, Obstacle::tof_lost, Obstacle::budget,
                                    Obstacle::interval, Obstacle::precision, Obstacle::unhelpful})
        CHECK_FALSE(to_string(obstacle).empty());
}
