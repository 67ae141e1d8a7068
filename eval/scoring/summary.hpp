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

/// What an evaluation comes to. Errors and coverage are over the estimated frames; nothing where
/// there is none.
struct Summary {
    std::string dataset;
    std::string preset;
    int frames = 0;
    int measured = 0;
    int damaged = 0;
    int unscored = 0;
    double duty_cycle = 0;                                     ///< percent of the frames
    std::optional<double> mre_median{}, mre_mean{}, mre_p95{}; ///< percent
    std::optional<double> mae_cm_median{}, rmse_cm_median{};
    std::optional<double> coverage_median{}, coverage_p5{}; ///< percent
    std::optional<double> expected_correlation{}; ///< of expected and true error, Pearson's
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

/// A small table for a person.
std::string to_text(const Summary &summary);

} // namespace afterglow
