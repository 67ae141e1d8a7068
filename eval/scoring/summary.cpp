// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace afterglow {
namespace {

std::string cell(const std::optional<double> &value, const char *unit) {
    return value ? fmt::format("{:.2f} {}", *value, unit) : "-";
}

} // namespace

std::optional<double> correlation(const std::vector<double> &a, const std::vector<double> &b) {
    if (a.size() < 3)
        return std::nullopt;
    const double mean_a = *mean(a);
    const double mean_b = *mean(b);
    double ab = 0;
    double aa = 0;
    double bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - mean_a) * (b[i] - mean_b);
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
    }
    if (!(aa > 0 && bb > 0))
        return std::nullopt;
    return ab / std::sqrt(aa * bb);
}

std::span<const Metric> summary_metrics() {
    static constexpr Metric all[] = {
        {"duty_cycle", "lit %", [](const Summary &s) { return std::optional(s.duty_cycle); }},
        {"measured_share", "measured %",
         [](const Summary &s) { return std::optional(s.measured_share); }},
        {"mre_median", "MRE med", [](const Summary &s) { return s.mre_median; }},
        {"mre_p95", "MRE p95", [](const Summary &s) { return s.mre_p95; }},
        {"coverage_median", "cov. med", [](const Summary &s) { return s.coverage_median; }},
        {"coverage_p5", "cov. p5", [](const Summary &s) { return s.coverage_p5; }},
    };
    return all;
}

std::optional<double> mean(const std::vector<double> &values) {
    if (values.empty())
        return std::nullopt;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<double> percentile(std::vector<double> values, double percent) {
    if (values.empty())
        return std::nullopt;
    std::sort(values.begin(), values.end());
    const double place = percent / 100 * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double share = place - static_cast<double>(below);
    return values[below] * (1 - share) + values[above] * share;
}

ExpectedAgainstTrue expected_against_true(const Evaluation &evaluation) {
    constexpr int learning_measurements = 3;
    int measured = 0;
    ExpectedAgainstTrue pairs;
    for (const FrameScore &frame : evaluation.frames) {
        measured += frame.measured;
        if (frame.measured || measured < learning_measurements || !frame.mre ||
            !frame.expected_mre || !(*frame.expected_mre > 0))
            continue;
        pairs.expected_mre.push_back(*frame.expected_mre);
        pairs.true_mre.push_back(*frame.mre);
    }
    return pairs;
}

Error no_true_depth(const std::string &sequence, std::size_t frames, const std::string &problem) {
    return {fmt::format("{}: nothing to score against: not one of {} frames has a depth map that "
                        "can be read and is not empty{}{}",
                        sequence, frames, problem.empty() ? "" : "; the first problem: ", problem)};
}

Status check_scored(const Evaluation &evaluation, const std::string &sequence) {
    const auto has_truth = [](const FrameScore &frame) { return frame.coverage.has_value(); };
    if (evaluation.frames.empty())
        return Error{fmt::format(
            "{}: not one usable frame{}{}", sequence,
            evaluation.problem.empty() ? "" : "; the first problem: ", evaluation.problem)};
    if (std::ranges::none_of(evaluation.frames, has_truth))
        return no_true_depth(sequence, evaluation.frames.size(), evaluation.problem);
    return ok();
}

Summary summarize(const Evaluation &evaluation, const std::string &dataset,
                  const std::string &preset, double target_mre) {
    Summary s{.dataset = dataset, .preset = preset};
    s.frames = static_cast<int>(evaluation.frames.size());
    s.damaged = evaluation.damaged;
    s.bad_maps = evaluation.bad_maps;
    s.unscored = evaluation.unscored;
    std::vector<double> mre, mae, rmse, coverage, ms, predicted, actual;
    for (const FrameScore &frame : evaluation.frames) {
        ms.push_back(frame.ms);
        s.lit += frame.lit;
        if (frame.measured) {
            ++s.measured;
            continue;
        }
        if (frame.coverage)
            coverage.push_back(*frame.coverage);
        if (!frame.mre)
            continue;
        mre.push_back(*frame.mre);
        mae.push_back(frame.mae_cm);
        rmse.push_back(frame.rmse_cm);
        if (frame.expected_mre) {
            predicted.push_back(*frame.expected_mre);
            actual.push_back(*frame.mre);
        }
    }
    const auto share = [&](int count) { return s.frames > 0 ? 100.0 * count / s.frames : 0; };
    s.duty_cycle = share(s.lit);
    s.measured_share = share(s.measured);
    s.mre_median = percentile(mre, 50);
    s.mre_mean = mean(mre);
    s.mre_p95 = percentile(mre, 95);
    s.mae_cm_median = percentile(mae, 50);
    s.rmse_cm_median = percentile(rmse, 50);
    s.coverage_median = percentile(coverage, 50);
    s.coverage_p5 = percentile(coverage, 5);
    s.expected_correlation = correlation(predicted, actual);
    const ExpectedAgainstTrue pairs = expected_against_true(evaluation);
    std::vector<double> ratios;
    std::ranges::transform(pairs.true_mre, pairs.expected_mre, std::back_inserter(ratios),
                           std::divides{});
    s.true_over_expected = percentile(ratios, 50);
    const auto share_over = [](const std::vector<double> &values, double limit) {
        const auto over = std::ranges::count_if(values, [&](double v) { return v > limit; });
        return values.empty() ? std::nullopt
                              : std::optional(100.0 * static_cast<double>(over) /
                                              static_cast<double>(values.size()));
    };
    s.misjudged_share = share_over(ratios, misjudged);
    s.frames_over_target = share_over(mre, target_mre);
    s.ms_per_frame_median = percentile(ms, 50);
    return s;
}

std::string duty_cycle_text(const Summary &s) {
    return fmt::format("lit {:.1f} %, measured {:.1f} %", s.duty_cycle, s.measured_share);
}

std::string to_text(const Summary &s) {
    std::string out = fmt::format("{}, preset {}\n", s.dataset, s.preset);
    const auto add = [&](const char *key, const std::string &value) {
        out += fmt::format("  {:<28}{}\n", key, value);
    };
    add("frames", std::to_string(s.frames));
    add("duty cycle", duty_cycle_text(s));
    add("MRE median", cell(s.mre_median, "%"));
    add("    mean", cell(s.mre_mean, "%"));
    add("    95th percentile", cell(s.mre_p95, "%"));
    add("    frames over the target", cell(s.frames_over_target, "%"));
    add("MAE median", cell(s.mae_cm_median, "cm"));
    add("RMSE median", cell(s.rmse_cm_median, "cm"));
    add("coverage median", cell(s.coverage_median, "%"));
    add("    5th percentile", cell(s.coverage_p5, "%"));
    add("time a frame, median", cell(s.ms_per_frame_median, "ms"));
    if (s.expected_correlation)
        add("expected against true MRE", fmt::format("r = {:.2f}", *s.expected_correlation));
    if (s.true_over_expected)
        add("    from 3rd measurement on",
            fmt::format("median of true / expected {:.2f}, above {:g} x expected {:.1f} %",
                        *s.true_over_expected, misjudged, *s.misjudged_share));
    if (s.damaged > 0)
        add("dropped as unusable", std::to_string(s.damaged));
    if (s.bad_maps > 0)
        add("unusable depth maps", std::to_string(s.bad_maps));
    if (s.unscored > 0)
        add("without a readable truth", std::to_string(s.unscored));
    return out;
}

} // namespace afterglow
