// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/wishes.hpp"

#include <algorithm>
#include <chrono>

namespace afterglow {
namespace {

/// Greater is stricter.
int strictness(GateMode mode) {
    switch (mode) {
    case GateMode::automatic:
        return 0;
    case GateMode::interval:
        return 1;
    case GateMode::always_on:
        return 2;
    case GateMode::off:
        break;
    }
    return 3;
}

bool meets(const afterglow_frame &frame, const Wish &wish) {
    const bool precise = wish.max_relative_error <= 0 ||
                         (frame.expected_mre >= 0 &&
                          static_cast<double>(frame.expected_mre) <= wish.max_relative_error);
    const bool young = wish.max_age_ms == 0 || std::chrono::nanoseconds(frame.age_ns) <=
                                                   std::chrono::milliseconds(wish.max_age_ms);
    return frame.source != AFTERGLOW_NONE && precise && young;
}

/// A mode is kept when it rules and its light is not refused.
Obstacle obstacle_of_mode(GateMode held, const Situation &situation) {
    if (held != situation.mode)
        return situation.mode == GateMode::off ? Obstacle::dark : Obstacle::overruled;
    const bool lights = held == GateMode::always_on || held == GateMode::interval;
    return lights && situation.budget_spent() ? Obstacle::budget : Obstacle::none;
}

/// An accuracy is kept when the newest frame has it, or a measurement is on its way.
Obstacle obstacle_of_accuracy(const Wish &wish, const Situation &situation) {
    if (!situation.frame || meets(situation.frame->frame, wish))
        return Obstacle::none;
    if (situation.mode == GateMode::off)
        return Obstacle::dark;
    if (situation.budget_spent())
        return Obstacle::budget;
    if (situation.frame->frame.source == AFTERGLOW_MEASURED)
        return Obstacle::precision;
    if (situation.frame->reason != GateReason::none)
        return Obstacle::none;
    return situation.mode == GateMode::interval ? Obstacle::interval : Obstacle::unhelpful;
}

} // namespace

GatePolicy strictest(GatePolicy own, const std::list<const Wish *> &wishes) {
    for (const Wish *wish : wishes)
        if (wish->kind == Wish::Kind::mode) {
            if (strictness(wish->mode) > strictness(own.mode))
                own.mode = wish->mode;
        } else {
            if (wish->max_relative_error > 0)
                own.target_mre = std::min(own.target_mre, wish->max_relative_error);
            const double age_ms = wish->max_age_ms;
            if (age_ms > 0 && (own.longest_age_ms <= 0 || age_ms < own.longest_age_ms))
                own.longest_age_ms = age_ms;
        }
    return own;
}

std::string_view to_string(Obstacle obstacle) {
    switch (obstacle) {
    case Obstacle::none:
        break;
    case Obstacle::overruled:
        return "a stricter mode rules";
    case Obstacle::dark:
        return "mode off rules";
    case Obstacle::asleep:
        return "nobody reads, the cameras sleep";
    case Obstacle::color_lost:
        return "the colour camera is lost";
    case Obstacle::tof_lost:
        return "the TOF camera is lost";
    case Obstacle::budget:
        return "the duty-cycle budget is spent";
    case Obstacle::interval:
        return "mode interval rules";
    case Obstacle::precision:
        return "the TOF camera does not measure better";
    case Obstacle::unhelpful:
        return "a measurement is not expected to help enough";
    }
    return "";
}

Obstacle obstacle_of(const Wish &wish, const Situation &situation) {
    const bool wants_dark = wish.kind == Wish::Kind::mode && wish.mode == GateMode::off;
    if (!wants_dark) {
        const auto &[color, tof] = situation.cameras;
        if (color == CameraState::asleep || color == CameraState::over)
            return Obstacle::asleep;
        if (color == CameraState::lost)
            return Obstacle::color_lost;
        if (tof == CameraState::lost)
            return Obstacle::tof_lost;
    }
    return wish.kind == Wish::Kind::mode ? obstacle_of_mode(wish.mode, situation)
                                         : obstacle_of_accuracy(wish, situation);
}

} // namespace afterglow
