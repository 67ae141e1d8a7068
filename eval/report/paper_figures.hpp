// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace afterglow::paper {

// Every figure that Noraky & Sze 2019 prints and a report shows beside ours. Theirs: on their data,
// on their board (ODROID-XU3, Cortex-A7).

/// A cell of Tables III and IV. `dataset`: one of the names of family_of(), "mean" or "median".
struct Errors {
    std::string_view dataset;
    std::string_view system;
    double mre, mae_cm, rmse_cm;
    std::optional<double> duty_cycle{};
};
std::optional<Errors> errors(std::string_view dataset, std::string_view system);

/// The dataset of the paper's that a sequence is of, by its layout or its folder's name: "tum",
/// "nyu", "indoor", "corbs", "icl". Empty for any other.
std::string_view family_of(std::string_view dataset, std::string_view layout);

/// The names of family_of(), in the paper's order.
std::span<const std::string_view> families();
/// As the paper prints it: "TU Munich RGB-D" for "tum". Empty for what is no family.
std::string_view family_title(std::string_view family);

/// Table I, milliseconds, by the name of a Timing.
std::optional<double> flow_ms(std::string_view name);
/// Table V, frames per second, by a system's name.
std::optional<double> frames_per_second(std::string_view system);
/// Table II, percent.
std::optional<double> ransac_reduction(bool depth, bool flow);

/// Share of a frame's time, percent, of the stages "flow", "pose" and "reprojection": from the 13
/// ms of Table I, the 30 frames a second of Table V and the 58 of Section V-A for the pose alone.
std::optional<double> stage_share(std::string_view stage);

inline constexpr double aimed_mre = 1; ///< percent, Section V-C: what thresholds are set for
inline constexpr double about_aimed_mre = 1.05;  ///< percent: the most that Table III has
inline constexpr double reverse_warp_mre = 17.4; ///< percent more, Section IV-C
inline constexpr double median_filter_mre = 0;   ///< percent more, Section IV-C: "unchanged"
inline constexpr double largest_holes = 3;       ///< percent, Section IV-C: "less than"
inline constexpr double out_of_range_mre = 0.87; ///< percent, Section VIII
inline constexpr double saturation_mre = 0.6;    ///< percent, Section VIII
inline constexpr double smallest_saving = 23;    ///< percent, Section VI, at P_TOF of 1 W
inline constexpr double largest_saving = 73;     ///< percent, at 5 W

/// Table VI, watts.
struct Power {
    double core_active, core_idle, memory_active, memory_idle;
};
inline constexpr Power power{0.63, 0.16, 0.06, 0.03};

} // namespace afterglow::paper
