// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/run_system.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <utility>

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

/// A quantity of a system over datasets; `choose` picks the setting.
std::vector<double> values_of(const Results &results, const std::vector<ScoredDataset> &datasets,
                              const Quantity &quantity, std::string_view system,
                              ChooseScore *choose) {
    std::vector<double> values;
    for (const ScoredDataset &dataset : datasets)
        if (const Score *score = choose(results.scores, dataset.name, system))
            if (const auto value = quantity.ours(score->summary))
                values.push_back(*value);
    return values;
}

/// What the datasets come to as a whole.
struct Total {
    const char *label;
    const char *paper; ///< the paper's row of that name, or ""
    std::optional<double> (*of)(const std::vector<double> &values);
    bool recorded; ///< over the recorded sequences alone
};
std::optional<double> median(const std::vector<double> &values) {
    return percentile(values, 50);
}
/// Those that say something: the recorded apart only where there are others, too.
std::vector<Total> totals_of(const std::vector<ScoredDataset> &datasets) {
    std::vector<Total> totals = {{"mean", "mean", mean, false},
                                 {"median", "median", median, false}};
    const auto synthetic = std::ranges::count(datasets, true, &ScoredDataset::synthetic);
    if (synthetic > 0 && synthetic < std::ssize(datasets))
        totals.push_back({"median of the recorded", "", median, true});
    return totals;
}

std::optional<double> total_of(const Total &total, const Results &results, const Quantity &quantity,
                               std::string_view system, ChooseScore *choose) {
    auto datasets = datasets_of(results.scores);
    if (total.recorded)
        std::erase_if(datasets, [](const ScoredDataset &dataset) { return dataset.synthetic; });
    return total.of(values_of(results, datasets, quantity, system, choose));
}

std::string setting_text(const Setting &setting) {
    return setting.name.empty() ? "" : fmt::format("{:g}", setting.value);
}

/// Table III of one system.
Table evaluation_table(const Results &results, const std::string &system, std::string id) {
    Table table{.id = std::move(id),
                .title = "Table III. Evaluation at about 1 % error: " + title_of(system),
                .explanation = "",
                .corner = "dataset",
                .columns = {},
                .rows = {}};
    for (const Quantity &quantity : quantities)
        table.columns.emplace_back(quantity.title);
    table.columns.emplace_back("setting");
    const auto datasets = datasets_of(results.scores);
    for (const ScoredDataset &dataset : datasets) {
        const Score *score = tuned_score(results.scores, dataset.name, system);
        Table::Row row{dataset.label(), {}};
        for (const Quantity &quantity : quantities)
            row.cells.push_back(cell_of(quantity,
                                        score ? quantity.ours(score->summary) : std::nullopt,
                                        dataset.family, system));
        row.cells.push_back({score ? setting_text(score->setting) : ""});
        table.rows.push_back(std::move(row));
    }
    for (const Total &total : totals_of(datasets)) {
        Table::Row row{total.label, {}};
        for (const Quantity &quantity : quantities)
            row.cells.push_back(cell_of(quantity,
                                        total_of(total, results, quantity, system, tuned_score),
                                        total.paper, system));
        row.cells.push_back({});
        table.rows.push_back(std::move(row));
    }
    return table;
}

constexpr const char *compared_systems[] = {"default", "paper", "oracle"};

/// The last rows of the summary: medians over the sequences.
std::optional<Table::Row> median_row(const Results &results, std::string_view system) {
    std::vector<const Summary *> summaries;
    for (const ScoredDataset &dataset : datasets_of(results.scores))
        if (const Score *score = preset_score(results.scores, dataset.name, system))
            summaries.push_back(&score->summary);
    if (summaries.empty())
        return std::nullopt;
    Table::Row row{fmt::format("median of {}", summaries.size()), {{title_of(system)}}};
    for (const Metric &metric : summary_metrics()) {
        std::vector<double> values;
        for (const Summary *summary : summaries)
            if (const auto value = metric.of(*summary))
                values.push_back(*value);
        row.cells.push_back({text_of(median(values), 2)});
    }
    row.cells.resize(row.cells.size() + 2); // no r, no frames
    return row;
}

} // namespace

std::optional<Table> summary_table(const Results &results) {
    Table table{.id = "summary",
                .title = "Summary",
                .explanation = "",
                .corner = "sequence",
                .columns = {"system"},
                .rows = {}};
    for (const Metric &metric : summary_metrics())
        table.columns.emplace_back(metric.title);
    table.columns.insert(table.columns.end(), {"r", "frames"});
    for (const ScoredDataset &dataset : datasets_of(results.scores))
        for (const char *system : compared_systems)
            if (const Score *score = preset_score(results.scores, dataset.name, system)) {
                const Summary &summary = score->summary;
                Table::Row row{dataset.label(), {{title_of(system)}}};
                for (const Metric &metric : summary_metrics())
                    row.cells.push_back({text_of(metric.of(summary), 2)});
                row.cells.push_back({text_of(summary.expected_correlation, 2)});
                row.cells.push_back({std::to_string(summary.frames)});
                table.rows.push_back(std::move(row));
            }
    if (table.rows.empty())
        return std::nullopt;
    std::vector<std::string> sentences;
    for (const char *system : compared_systems)
        if (auto row = median_row(results, system)) {
            // Duty cycle and median MRE are the first of summary_metrics().
            sentences.push_back(fmt::format("{} lights the TOF camera in {} % of the frames, with "
                                            "a median error of {} %",
                                            title_of(system), row->cells[1].ours,
                                            row->cells[2].ours));
            table.rows.push_back(*std::move(row));
        }
    table.explanation = fmt::format(
        "Medians over the sequences: {}. No system is tuned to the data: afterglow with preset "
        "default, This Work with the "
        "threshold of the paper, the oracle, which sees the true depth, at 1.5 %. MRE (mean "
        "relative error) and coverage are over the estimated frames; MRE counts only pixels that "
        "are covered. r: correlation of a frame's expected error with its true one.",
        fmt::join(sentences, "; "));
    return table;
}

std::vector<Table> evaluation_tables(const Results &results) {
    std::vector<Table> tables;
    for (const std::string &name : systems_of(results.scores)) {
        const SystemDescription *system = find_system(name);
        if (system && name != "paper" && name != "default")
            continue;
        // The name may be anybody's, and the id becomes a file's name.
        tables.push_back(evaluation_table(
            results, name,
            tables.empty() ? "table-3" : fmt::format("table-3-{}", tables.size() + 1)));
    }
    if (!tables.empty())
        tables.front().explanation =
            "Medians over the estimated frames. For every dataset the paper's threshold, and "
            "afterglow's target, are set as the paper does it, for a median MRE of about 1 %: the "
            "darkest that has no more, or else the one that comes nearest. Coverage: how much of "
            "the true depth the estimates cover. A stand-in is the "
            "synthetic room, filmed like a dataset of the paper's that is not at hand.";
    return tables;
}

std::vector<Table> comparison_tables(const Results &results) {
    std::vector<Table> tables;
    const auto datasets = datasets_of(results.scores);
    const auto totals = totals_of(datasets);
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
                    .corner = "dataset",
                    .columns = {},
                    .rows = {}};
        std::ranges::transform(systems, std::back_inserter(table.columns), title_of);
        for (const ScoredDataset &dataset : datasets) {
            Table::Row row{dataset.label(), {}};
            for (const std::string &system : systems) {
                const Score *score = matched_score(results.scores, dataset.name, system);
                row.cells.push_back(cell_of(quantity,
                                            score ? quantity.ours(score->summary) : std::nullopt,
                                            dataset.family, system));
            }
            table.rows.push_back(std::move(row));
        }
        for (const Total &total : totals) {
            Table::Row row{total.label, {}};
            for (const std::string &system : systems)
                row.cells.push_back(
                    cell_of(quantity, total_of(total, results, quantity, system, matched_score),
                            total.paper, system));
            table.rows.push_back(std::move(row));
        }
        tables.push_back(std::move(table));
    }
    return tables;
}

} // namespace afterglow
