// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

std::vector<double> values_of(const Results &results, const std::string &variant,
                              const Metric &metric) {
    const bool any_headline =
        std::ranges::any_of(results.ablations, is_headline, &Ablation::summary);
    std::vector<double> values;
    for (const Ablation &ablation : results.ablations)
        if (ablation.variant == variant && (is_headline(ablation.summary) || !any_headline))
            if (const auto value = metric.of(ablation.summary))
                values.push_back(*value);
    return values;
}

} // namespace

std::optional<Table> reprojection_table(const Results &results) {
    Table table{.id = "reprojection",
                .title = "The paper's choices of reprojection",
                .explanation = "Against This Work at its own threshold on the same frames: what "
                               "changes if depth is fetched by reverse warping, or a 3x3 median "
                               "filter fills the holes.",
                .corner = "dataset",
                .columns = {"reverse warp: MRE (%)", "median filter: MRE (%)", "holes filled (%)"},
                .rows = {}};
    std::vector<double> reverse_changes, median_changes, holes_filled;
    const auto headline = headline_of(datasets_of(results.scores));
    bool counts = true; // for the medians
    const auto change = [&](const std::optional<double> &to, const std::optional<double> &from,
                            std::vector<double> &all) {
        if (!to || !from || !(*from > 0))
            return std::string();
        const double percent = 100 * (*to / *from - 1);
        if (counts)
            all.push_back(percent);
        return fmt::format("{:+.1f}", percent);
    };
    for (const ScoredDataset &dataset : datasets_of(results.scores)) {
        const Score *base = preset_score(results.scores, dataset.name, "paper");
        const Score *reverse = preset_score(results.scores, dataset.name, "reverse-warp");
        const Score *median = preset_score(results.scores, dataset.name, "median");
        if (!base || !reverse || !median)
            continue;
        const Summary &b = base->summary;
        counts = std::ranges::find(headline, dataset.name, &ScoredDataset::name) != headline.end();
        table.rows.push_back(
            {dataset.label(),
             {{change(reverse->summary.mre_median, b.mre_median, reverse_changes)},
              {change(median->summary.mre_median, b.mre_median, median_changes)},
              {change(median->summary.coverage_median, b.coverage_median, holes_filled)}}});
    }
    if (table.rows.empty())
        return std::nullopt;
    const auto over_all = [](const std::vector<double> &values) {
        const auto middle = percentile(values, 50);
        return middle ? fmt::format("{:+.1f}", *middle) : "";
    };
    table.rows.push_back(
        {"median",
         {{over_all(reverse_changes), fmt::format("{:+.1f}", paper::reverse_warp_mre)},
          {over_all(median_changes), fmt::format("{:+.1f}", paper::median_filter_mre)},
          {over_all(holes_filled), fmt::format("< {:.0f}", paper::largest_holes)}}});
    return table;
}

std::optional<Table> stage_worth_table(const Results &results) {
    if (results.ablations.empty())
        return std::nullopt;
    Table table{.id = "stages",
                .title = "Ablation of afterglow's stages",
                .explanation = "Means over the recordings of at least 30 frames, where there are "
                               "such, and what changes when a stage is switched "
                               "off; of each dataset in ablations.csv.",
                .corner = "variant",
                .columns = {},
                .rows = {}};
    for (const Metric &metric : summary_metrics())
        table.columns.emplace_back(metric.title);
    table.columns.emplace_back("what is lost");
    const std::string &all = results.ablations.front().variant;
    for (const Ablation &ablation : results.ablations) {
        if (std::ranges::find(table.rows, ablation.variant, &Table::Row::label) != table.rows.end())
            continue;
        Table::Row row{ablation.variant, {}};
        for (const Metric &metric : summary_metrics()) {
            const auto value = mean(values_of(results, ablation.variant, metric));
            const auto base = mean(values_of(results, all, metric));
            const bool changes = value && base && ablation.variant != all;
            row.cells.push_back(
                {text_of(value, 2) + (changes ? fmt::format(" ({:+.2f})", *value - *base) : "")});
        }
        row.cells.push_back({ablation.shows});
        table.rows.push_back(std::move(row));
    }
    return table;
}

} // namespace afterglow
