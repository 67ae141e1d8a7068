// SPDX-License-Identifier: Apache-2.0
#include "eval/report/figures.hpp"

#include "eval/experiments/run_system.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr int paper_color = plot_colors - 1;
constexpr int alone_color = plot_colors - 2; // of the TOF camera

/// The place in systems(), so that a system has one colour everywhere.
int color_of(std::string_view system) {
    const auto all = systems();
    const auto found = std::ranges::find(all, system, &SystemDescription::name);
    return static_cast<int>(found - all.begin()) % alone_color;
}

bool is_curve(std::span<const Score> scores, std::string_view dataset, std::string_view system) {
    const SystemDescription *known = find_system(system);
    return (!known || known->dense) && scores_of(scores, dataset, system).size() > 1;
}

Plot tradeoff_panel(const Results &results, const ScoredDataset &scored) {
    const std::string &dataset = scored.name;
    Plot plot{
        .title = scored.label(),
        .x = {.label = "frames lit (%), log scale", .min = 0.5, .max = 100, .logarithmic = true},
        .y = {.label = "median MRE (%), log scale", .min = 0.05, .max = 20, .logarithmic = true},
        .series = {}};
    for (const std::string &system : systems_of(results.scores)) {
        if (!is_curve(results.scores, dataset, system))
            continue;
        Plot::Series series{.name = title_of(system), .color = color_of(system), .points = {}};
        for (const Score *score : scores_of(results.scores, dataset, system))
            series.points.emplace_back(score->summary.duty_cycle, *score->summary.mre_median);
        plot.series.push_back(std::move(series));
    }
    const auto theirs = paper::errors(scored.family.empty() ? "median" : scored.family, "paper");
    if (theirs && theirs->duty_cycle)
        plot.series.push_back({.name = "the paper's figure, on its data",
                               .color = paper_color,
                               .line = false,
                               .points = {{*theirs->duty_cycle, theirs->mre}}});
    return plot;
}

Figure tradeoff_figure(const Results &results) {
    Figure figure{.id = "tradeoff",
                  .title = "Duty cycle against error",
                  .explanation = "Down and left is better. Every point is a setting: the threshold "
                                 "of This Work and LK, afterglow's target, the interval of the "
                                 "others. Structure from motion, which has no TOF camera, is in "
                                 "Table IV. Points beyond the axes lie at their edge, hollow."};
    for (const ScoredDataset &dataset : datasets_of(results.scores)) {
        Plot panel = tradeoff_panel(results, dataset);
        if (panel.series.size() > 1)
            figure.panels.push_back(std::move(panel));
    }
    return figure;
}

/// A line of a constant ratio of true to expected error.
Plot::Series ratio_line(const char *name, double ratio, bool dashed, const Plot &plot) {
    return {.name = name,
            .color = alone_color,
            .marks = false,
            .dashed = dashed,
            .points = {{plot.x.min, ratio * plot.x.min}, {plot.y.max / ratio, plot.y.max}}};
}

Figure calibration_figure(const Results &results) {
    Figure figure{.id = "calibration-plots",
                  .title = "Expected against true error, frame by frame",
                  .explanation =
                      "Each point is an estimated frame of afterglow with its default target, from "
                      "the third measurement on. On the line 1:1 the expected error is the true "
                      "one; above 1.5:1 the frame is misjudged. Points beyond the axes lie at "
                      "their edge, hollow."};
    for (const ScoredDataset &dataset : datasets_of(results.scores)) {
        const Score *score = preset_score(results.scores, dataset.name, "default");
        if (!score || score->calibration.true_mre.empty())
            continue;
        const auto &[expected, actual] = score->calibration;
        Plot plot{
            .title = dataset.label(),
            .x = {.label = "expected MRE (%), log scale",
                  .min = 0.05,
                  .max = 20,
                  .logarithmic = true},
            .y = {.label = "true MRE (%), log scale", .min = 0.05, .max = 20, .logarithmic = true},
            .series = {}};
        plot.series.push_back(ratio_line("1:1", 1, false, plot));
        plot.series.push_back(ratio_line("1.5:1", misjudged, true, plot));
        Plot::Series frames{.name = "frames of afterglow",
                            .color = color_of("default"),
                            .line = false,
                            .radius = 2.5,
                            .points = {}};
        for (std::size_t i = 0; i < actual.size(); ++i)
            frames.points.emplace_back(expected[i], actual[i]);
        plot.series.push_back(std::move(frames));
        figure.panels.push_back(std::move(plot));
    }
    return figure;
}

Figure power_figure(const Results &results) {
    Figure figure{.id = "system-power",
                  .title = "Power of the whole system",
                  .explanation = std::string("Eq. 9 over the power of the TOF camera, with each "
                                             "system's median duty cycle in Table III. ") +
                                 what_is_charged};
    Plot plot{.title = "TOF camera and estimation",
              .x = {.label = "power of the TOF camera (W)", .min = 1, .max = 5},
              .y = {.label = "power of the system (W)", .min = 0, .max = 5},
              .series = {}};
    const auto add = [&](std::string name, int color, auto power) {
        Plot::Series series{.name = std::move(name), .color = color, .marks = false, .points = {}};
        for (const double tof_w : {1.0, 2.0, 3.0, 4.0, 5.0})
            series.points.emplace_back(tof_w, power(tof_w));
        plot.series.push_back(std::move(series));
    };
    const auto add_system = [&](std::string name, int color, const ProcessingPower &processing,
                                double duty_cycle) {
        add(std::move(name), color,
            [&](double tof_w) { return processing.system_w(duty_cycle, tof_w); });
    };
    for (const char *name : {"paper", "default"}) {
        const auto duty_cycle = typical_duty_cycle(results, name);
        const auto processing = processing_power(results, name);
        if (duty_cycle && processing)
            add_system(title_of(name), color_of(name), *processing, *duty_cycle);
    }
    if (plot.series.empty())
        return figure;
    add_system("the paper's figure, on its data", paper_color, *processing_power(results, "paper"),
               *paper::errors("median", "paper")->duty_cycle);
    add("the TOF camera alone", alone_color, [](double tof_w) { return tof_w; });
    figure.panels.push_back(std::move(plot));
    return figure;
}

Figure stage_figure(const Results &results) {
    Figure figure{.id = "run-time-shares",
                  .title = "Run-time breakdown",
                  .explanation = "The stages of the paper's system, each a share of the whole."};
    Bars bars{.title = "flow, pose, reprojection", .parts = {}, .bars = {}};
    Bars::Bar ours{"measured here", {}};
    Bars::Bar theirs{"in the paper, on its board", {}};
    for (const Timing &timing : results.stage_times) {
        const auto share = paper::stage_share(timing.name);
        if (!share) // "all"
            continue;
        bars.parts.push_back(timing.name);
        ours.shares.push_back(100 * timing.ratio);
        theirs.shares.push_back(*share);
    }
    if (bars.parts.empty())
        return figure;
    bars.bars = {std::move(ours), std::move(theirs)};
    figure.bars.push_back(std::move(bars));
    return figure;
}

} // namespace

std::vector<Figure> make_figures(const Results &results) {
    std::vector<Figure> figures;
    for (Figure figure : {tradeoff_figure(results), calibration_figure(results),
                          stage_figure(results), power_figure(results)})
        if (!figure.panels.empty() || !figure.bars.empty())
            figures.push_back(std::move(figure));
    return figures;
}

} // namespace afterglow
