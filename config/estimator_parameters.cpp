// SPDX-License-Identifier: Apache-2.0
#include "config/estimator_parameters.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <string>
#include <vector>

namespace afterglow {
namespace {

constexpr std::string_view preset_names[] = {"paper"};
// In the order of enum GateMode.
constexpr std::string_view gate_modes[] = {"auto", "always-on", "interval", "off"};

constexpr Parameter<const Tuning> parameters[] = {
    {"flow.grid",
     {.minimum = 2, .maximum = 64, .unit = "points"},
     "points along each side of the uniform grid that is tracked",
     [](const Tuning &t) -> Field { return &t.estimator.flow.grid; }},
    {"flow.block",
     {.minimum = 3, .maximum = 63, .unit = "pixels", .step = 2},
     "side of the block compared around a point",
     [](const Tuning &t) -> Field { return &t.estimator.flow.block; }},
    {"flow.step",
     {.minimum = 1, .maximum = 64, .unit = "pixels"},
     "first step of the three-step search; halved down to 1",
     [](const Tuning &t) -> Field { return &t.estimator.flow.step; }},
    {"ransac.draws",
     {.minimum = 1, .maximum = 10000},
     "pose hypotheses drawn for each image",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.draws; }},
    {"ransac.hypothesis_iterations",
     {.minimum = 1, .maximum = 100},
     "Gauss-Newton steps on the 3 matches of a draw",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.hypothesis_iterations; }},
    {"ransac.refine_iterations",
     {.minimum = 1, .maximum = 100},
     "Gauss-Newton steps on the inliers of a draw",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.refine_iterations; }},
    {"ransac.threshold",
     {.minimum = 0.01, .maximum = 10000, .unit = "square pixels"},
     "largest squared residual of an inlier",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.threshold; }},
    {"ransac.min_inliers",
     {.minimum = 0, .maximum = 100, .unit = "percent"},
     "share of the grid that an accepted pose explains; less asks for a measurement",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.min_inliers; }},
    {"ransac.seed",
     {.minimum = 0, .maximum = 4294967295},
     "seed of the draws: the same seed gives the same depth",
     [](const Tuning &t) -> Field { return &t.estimator.ransac.seed; }},
    {"gate.mode",
     {.choices = gate_modes},
     "who decides when the TOF camera is lit",
     [](const Tuning &t) -> Field { return enum_field(t.gate.mode); }},
    {"gate.interval_frames",
     {.minimum = 1, .maximum = 100000, .unit = "frames"},
     "in mode interval: one frame in so many is measured",
     [](const Tuning &t) -> Field { return &t.gate.interval_frames; }},
};

} // namespace

std::span<const Parameter<const Tuning>> estimator_parameters() {
    return parameters;
}

std::span<const std::string_view> estimator_preset_names() {
    return preset_names;
}

Status set_parameter(EstimatorOptions &estimator, GatePolicy &gate, std::string_view key,
                     std::string_view value) {
    const Tuning tuning{estimator, gate};
    std::vector<std::string> keys;
    for (const auto &parameter : parameters) {
        if (parameter.key == key) {
            const Status set = assign_text(parameter.field(tuning), parameter.allowed, value);
            if (!set)
                return Error{fmt::format("{}: {}", key, set.error().message), EINVAL};
            return ok();
        }
        keys.emplace_back(parameter.key);
    }
    return Error{fmt::format("{}: there is no such parameter{}", key, suggestion(key, keys)),
                 EINVAL};
}

} // namespace afterglow
