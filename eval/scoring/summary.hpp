// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/scoring/evaluation.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

/// Nothing of no values.
std::optional<double> mean(const std::vector<double> &values);

/// The value below which `percent` of the values lie, interpolated; nothing of no values.
std::optional<double> percentile(std::vector<double> values, double percent);

/// Pearson's correlation; nothing for fewer than three pairs or values that do not vary.
std::optional<double> correlation(const std::vector<double> &a, const std::vector<double> &b);

/// The estimated frames of which both the expected and the true error are known, from the third
/// measurement on: before, the estimator has not learned the scale of its expected error.
struct ExpectedAgainstTrue {
    std::vector<double> expected_mre; ///< percent; one for each frame
    std::vector<double> true_mre;     ///< percent; one for each frame
};
ExpectedAgainstTrue expected_against_true(const Evaluation &evaluation);

/// A frame whose true error is more times the expected one is one that the estimator misjudged.
inline constexpr double misjudged = 1.5;

/// What an evaluation comes to. Errors and coverage are over the estimated frames; nothing where
/// there is none.
///
/// The duty cycle is the share of the published frames for which the illuminator was lit. Frames
/// count from the very first: those for which the TOF camera is awaited or wakes up are lit and not
/// measured, also when the recording ends before the map comes. Frames that were dropped as
/// unusable do not count.
struct Summary {
    std::string dataset;
    std::string preset;
    int frames = 0;
    int lit = 0;
    int measured = 0;
    int damaged = 0;
    int bad_maps = 0; ///< Evaluation::bad_maps
    int unscored = 0;
    double duty_cycle = 0;                                     ///< frames lit, percent
    double measured_share = 0;                                 ///< frames measured, percent
    std::optional<double> mre_median{}, mre_mean{}, mre_p95{}; ///< percent
    std::optional<double> mae_cm_median{}, rmse_cm_median{};
    std::optional<double> coverage_median{}, coverage_p5{}; ///< percent
    std::optional<double> expected_correlation{}; ///< of expected and true error, Pearson's
    /// Of expected_against_true(): median of true / expected, and percent of the frames misjudged.
    std::optional<double> true_over_expected{}, misjudged_share{};
    /// Percent of the estimated frames whose true MRE exceeds the target of the gate.
    std::optional<double> frames_over_target{};
    std::optional<double> ms_per_frame_median{};
};

/// The Error of a sequence without a single true depth. `problem`: the first sentence on why a
/// frame could not be used; or empty.
Error no_true_depth(const std::string &sequence, std::size_t frames, const std::string &problem);
/// That, where no published frame has a true depth; another Error where no frame was published.
Status check_scored(const Evaluation &evaluation, const std::string &sequence);

/// `target_mre`: GatePolicy's, percent.
Summary summarize(const Evaluation &evaluation, const std::string &dataset,
                  const std::string &preset, double target_mre);

/// One of the few numbers that tell how dark and how wrong, percent.
struct Metric {
    std::string_view key; ///< in JSON
    std::string_view title;
    std::optional<double> (*of)(const Summary &summary);
};
std::span<const Metric> summary_metrics();

/// "lit 45.0 %, measured 14.0 %".
std::string duty_cycle_text(const Summary &summary);

/// A small table for a person.
std::string to_text(const Summary &summary);

} // namespace afterglow
