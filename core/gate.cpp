// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"

#include <array>
#include <utility>

namespace afterglow {
namespace {

constexpr std::array<std::pair<GateMode, std::string_view>, 4> mode_names{{
    {GateMode::automatic, "auto"},
    {GateMode::always_on, "always-on"},
    {GateMode::interval, "interval"},
    {GateMode::off, "off"},
}};

} // namespace

std::string_view to_string(GateMode mode) {
    for (const auto &[value, name] : mode_names)
        if (value == mode)
            return name;
    return {};
}

std::optional<GateMode> gate_mode_from_string(std::string_view name) {
    for (const auto &[value, known] : mode_names)
        if (known == name)
            return value;
    return std::nullopt;
}

bool Gate::wants_light(const Estimate &estimate) {
    if (frames_since_measurement_ >= 0)
        ++frames_since_measurement_;
    const bool never_measured = frames_since_measurement_ < 0;
    switch (policy_.mode) {
    case GateMode::automatic:
        waiting_ = waiting_ || never_measured || estimate.wants_measurement;
        break;
    case GateMode::always_on:
        waiting_ = true;
        break;
    case GateMode::interval:
        waiting_ =
            waiting_ || never_measured || frames_since_measurement_ >= policy_.interval_frames;
        break;
    case GateMode::off:
        waiting_ = false;
        break;
    }
    return waiting_;
}

void Gate::measured() {
    frames_since_measurement_ = 0;
    waiting_ = false;
}

} // namespace afterglow
