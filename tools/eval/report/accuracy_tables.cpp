// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/paper_figures.hpp"
#include "tools/eval/report/play.hpp"
#include "tools/eval/report/table_makers.hpp"
#include "tools/eval/report/tradeoff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace afterglow {
namespace {

using Value = std::optional<double> (*)(const Summary &);
using PaperValue = std::optional<double> (*)(const paper::Errors &);

/// What is scored, as Tables III and IV print it.
struct Quantity {
    const char *id;
    const char *title;
    int digits;
    Value ours;
    PaperValue theirs;
};

constexpr Quantity quantities[] = {
    {"mre", "MRE (%)", 2, [](const Summary &s) { return s.mre_median; },
     [](const paper::Errors &e) { return std::optional(e.mre); }},
    {"mae", "MAE (cm)", 2, [](const Summary &s) { return s.mae_cm_median; },
     [](const paper::Errors &e) { return std::optional(e.mae_cm); }},
    {"rmse", "RMSE (cm)", 2, [](const Summary &s) { return s.rmse_cm_median; },
     [](const paper::Errors &e) { return std::optional(e.rmse_cm); }},
    {"duty-cycle", "DC (%)", 1, [](const Summary &s) { return std::optional(s.duty_cycle); },
     [](const paper::Errors &e) { return e.duty_cycle; }},
    {"coverage", "coverage (%)", 1, [](const Summary &s) { return s.coverage_median; },
     [](const paper::Errors &) { return std::optional<double>(); }},
};

Table::Cell cell_of(const Quantity &quantity, const std::optional<double> &ours,
                    std::string_view paper_dataset, std::string_view system) {
    const auto printed = paper::errors(paper_dataset, system);
    return {text_of(ours, quantity.digits),
            printed ? text_of(quantity.theirs(*printed), quantity.digits) : ""};
}

std::optional<double> mean(const std::vector<double> &values) {
    if (values.empty())
        return std::nullopt;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// A quantity of a system over all datasets; `choose` picks the setting.
std::vector<double> all_values(const Results &results, const Quantity &quantity,
                               std::string_view system, ChooseScore *choose) {
    std::vector<double> values;
    for (const std::string &dataset : datasets_of(results.scores))
        if (const Score *score = choose(results.scores, dataset, system))
            if (const auto value = quantity.ours(score->summary))
                values.push_back(*value);
    return values;
}

std::string_view layout_of(const Results &results, const std::string &dataset) {
    for (const Score &score : results.scores)
        if (score.summary.dataset == dataset)
            return score.layout;
    return {};
}

std::string setting_text(const Setting &setting) {
    return setting.name.empty() ? "" : fmt::format("{:g}", setting.value);
}

} // namespace

std::vector<std::string> datasets_of(std::span<const Score> scores) {
    std::vector<std::string> names;
    for (const Score &score : scores)
        if (std::ranges::find(names, score.summary.dataset) == names.end())
            names.push_back(score.summary.dataset);
    return names;
}

std::vector<std::string> systems_of(std::span<const Score> scores) {
    std::vector<std::string> names;
    for (const SystemDescription &system : lineup())
        if (std::ranges::any_of(scores,
                                [&](const Score &s) { return s.summary.preset == system.name; }))
            names.emplace_back(system.name);
    for (const Score &score : scores) // and those that others have brought
        if (std::ranges::find(names, score.summary.preset) == names.end())
            names.push_back(score.summary.preset);
    return names;
}

std::optional<Table> evaluation_table(const Results &results) {
    Table table{.id = "table-3",
                .title = "Table III. Evaluation at about 1 % error",
                .explanation =
                    "Medians over the estimated frames. For every dataset the paper's threshold "
                    "and afterglow's target are set as the paper does it: to come nearest to a "
                    "median MRE of 1 %. Coverage: how much of the true depth the estimates cover.",
                .corner = "dataset",
                .columns = {},
                .rows = {}};
    std::vector<std::string> systems;
    for (const std::string &name : systems_of(results.scores)) {
        const SystemDescription *system = find_system(name);
        if (!system || name == "paper" || name == "default" || name == "oracle")
            systems.push_back(name);
    }
    for (const std::string &system : systems) {
        for (const Quantity &quantity : quantities)
            table.columns.push_back(title_of(system) + ' ' + quantity.title);
        table.columns.push_back(title_of(system) + " setting");
    }
    for (const std::string &dataset : datasets_of(results.scores)) {
        Table::Row row{dataset, {}};
        const auto family = paper::family_of(dataset, layout_of(results, dataset));
        for (const std::string &system : systems) {
            const Score *score = tuned_score(results.scores, dataset, system);
            for (const Quantity &quantity : quantities)
                row.cells.push_back(cell_of(quantity,
                                            score ? quantity.ours(score->summary) : std::nullopt,
                                            family, system));
            row.cells.push_back({score ? setting_text(score->setting) : ""});
        }
        table.rows.push_back(std::move(row));
    }
    for (const char *kind : {"mean", "median"}) {
        Table::Row row{kind, {}};
        for (const std::string &system : systems) {
            for (const Quantity &quantity : quantities) {
                const auto values = all_values(results, quantity, system, tuned_score);
                row.cells.push_back(
                    cell_of(quantity,
                            *kind == 'm' && kind[2] == 'a' ? mean(values) : percentile(values, 50),
                            kind, system));
            }
            row.cells.push_back({});
        }
        table.rows.push_back(std::move(row));
    }
    if (systems.empty() || table.rows.size() < 3)
        return std::nullopt;
    return table;
}

std::vector<Table> comparison_tables(const Results &results) {
    std::vector<Table> tables;
    const auto datasets = datasets_of(results.scores);
    const auto systems = systems_of(results.scores);
    if (systems.size() < 3)
        return tables;
    for (const Quantity &quantity : quantities) {
        Table table{.id = fmt::format("table-4-{}", quantity.id),
                    .title = fmt::format("Table IV. Comparison: {}", quantity.title),
                    .explanation = tables.empty()
                                       ? "All systems on the same frames. Each has the setting, or "
                                         "the interval, whose duty cycle comes nearest to that of "
                                         "afterglow in Table III. Structure from motion has no TOF "
                                         "camera: it gives depth at keypoints alone, scaled to fit "
                                         "the truth. The oracle sees the truth, too: it shows what "
                                         "a perfect pose would leave."
                                       : "",
                    .corner = "system",
                    .columns = datasets,
                    .rows = {}};
        table.columns.insert(table.columns.end(), {"mean", "median"});
        for (const std::string &system : systems) {
            Table::Row row{title_of(system), {}};
            for (const std::string &dataset : datasets) {
                const Score *score = matched_score(results.scores, dataset, system);
                row.cells.push_back(
                    cell_of(quantity, score ? quantity.ours(score->summary) : std::nullopt,
                            paper::family_of(dataset, layout_of(results, dataset)), system));
            }
            const auto values = all_values(results, quantity, system, matched_score);
            row.cells.push_back(cell_of(quantity, mean(values), "mean", system));
            row.cells.push_back(cell_of(quantity, percentile(values, 50), "median", system));
            table.rows.push_back(std::move(row));
        }
        tables.push_back(std::move(table));
    }
    return tables;
}

std::optional<Table> ablation_table(const Results &results) {
    Table table{.id = "ablations",
                .title = "The paper's choices of reprojection",
                .explanation = "Against This Work at its own threshold on the same frames: what "
                               "changes if depth is fetched by reverse warping, or a 3x3 median "
                               "filter fills the holes.",
                .corner = "dataset",
                .columns = {"reverse warp: MRE (%)", "median filter: MRE (%)", "holes filled (%)"},
                .rows = {}};
    std::vector<double> reverse_changes, median_changes, holes_filled;
    const auto change = [](const std::optional<double> &to, const std::optional<double> &from,
                           std::vector<double> &all) {
        if (!to || !from || !(*from > 0))
            return std::string();
        all.push_back(100 * (*to / *from - 1));
        return fmt::format("{:+.1f}", all.back());
    };
    for (const std::string &dataset : datasets_of(results.scores)) {
        const Score *base = plain_score(results.scores, dataset, "paper");
        const Score *reverse = plain_score(results.scores, dataset, "reverse-warp");
        const Score *median = plain_score(results.scores, dataset, "median");
        if (!base || !reverse || !median)
            continue;
        const Summary &b = base->summary;
        table.rows.push_back(
            {dataset,
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

} // namespace afterglow
