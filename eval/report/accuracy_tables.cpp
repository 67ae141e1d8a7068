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
    {"duty-cycle", "lit (%)", 1, [](const Summary &s) { return std::optional(s.duty_cycle); },
     [](const paper::Errors &e) { return e.duty_cycle; }},
    {"measured", "measured (%)", 1,
     [](const Summary &s) { return std::optional(s.measured_share); },
     [](const paper::Errors &) { return std::optional<double>(); }},
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

std::optional<double> median(const std::vector<double> &values) {
    return percentile(values, 50);
}

/// What datasets come to as a whole.
struct Total {
    std::string label;
    const char *paper; ///< the paper's row of that name, or ""
    std::optional<double> (*of)(const std::vector<double> &values);
    std::vector<ScoredDataset> datasets;
};

/// Those over headline_of() first; short clips and rooms apart.
std::vector<Total> totals_of(const std::vector<ScoredDataset> &datasets) {
    const auto headline = headline_of(datasets);
    std::vector<Total> totals = {
        {fmt::format("mean of {}", headline.size()), "mean", mean, headline},
        {fmt::format("median of {}", headline.size()), "median", median, headline}};
    std::vector<ScoredDataset> others;
    std::ranges::copy_if(datasets, std::back_inserter(others), [&](const ScoredDataset &dataset) {
        return std::ranges::find(headline, dataset.name, &ScoredDataset::name) == headline.end();
    });
    if (!others.empty())
        totals.push_back({"median of clips and rooms", "", median, std::move(others)});
    return totals;
}

std::optional<double> total_of(const Total &total, const Results &results, const Quantity &quantity,
                               std::string_view system, ChooseScore *choose) {
    return total.of(values_of(results, total.datasets, quantity, system, choose));
}

/// matched_score(), where its duty cycle is near enough to compare with; a system without a TOF
/// camera has none.
const Score *comparable_score(std::span<const Score> scores, std::string_view dataset,
                              std::string_view system) {
    const Score *score = matched_score(scores, dataset, system);
    const SystemDescription *known = find_system(system);
    const bool dark = known && known->lighting == Lighting::never;
    return score && (dark ||
                     is_near(score->summary.duty_cycle, compared_duty_cycle(scores, dataset)))
               ? score
               : nullptr;
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
std::optional<Table::Row> median_row(const Results &results,
                                     const std::vector<ScoredDataset> &datasets,
                                     std::string_view system) {
    std::vector<const Summary *> summaries;
    for (const ScoredDataset &dataset : datasets)
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

Table untuned_table(const Results &results, const std::vector<ScoredDataset> &datasets) {
    Table table{.id = "",
                .title = "",
                .explanation = "",
                .corner = "sequence",
                .columns = {"system"},
                .rows = {}};
    for (const Metric &metric : summary_metrics())
        table.columns.emplace_back(metric.title);
    table.columns.insert(table.columns.end(), {"r", "frames"});
    for (const ScoredDataset &dataset : datasets)
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
    return table;
}

} // namespace

std::optional<Table> summary_table(const Results &results) {
    const auto datasets = headline_of(datasets_of(results.scores));
    Table table = untuned_table(results, datasets);
    if (table.rows.empty())
        return std::nullopt;
    table.id = "summary";
    const bool recorded = datasets.front().headline;
    table.title = recorded ? "Summary: recordings" : "Summary: short clips and synthetic rooms";
    std::vector<std::string> sentences;
    for (const char *system : compared_systems)
        if (auto row = median_row(results, datasets, system)) {
            // The shares lit and measured and the median MRE are the first of summary_metrics().
            sentences.push_back(fmt::format("{}: lit {} %, measured {} %, median error {} %",
                                            title_of(system), row->cells[1].ours,
                                            row->cells[2].ours, row->cells[3].ours));
            table.rows.push_back(*std::move(row));
        }
    table.explanation = fmt::format(
        "Medians over the {}: {}. No system is tuned to the data: afterglow with preset default, "
        "This Work with the threshold of the paper. True-depth pose is afterglow with its pose "
        "refined on the true depth and lit by the true error at 1.5 % and by coverage; it lights "
        "other frames, so "
        "it is no bound. Lit: frames for which the illuminator is on, those of the TOF camera's "
        "waking up included. MRE (mean relative error) and coverage are over the estimated frames; "
        "MRE counts only pixels that are covered. r: correlation of a frame's expected error with "
        "its true one.",
        recorded ? "recordings of at least 30 frames" : "short clips and synthetic rooms alone",
        fmt::join(sentences, "; "));
    return table;
}

std::optional<Table> other_summary_table(const Results &results) {
    auto datasets = datasets_of(results.scores);
    if (std::ranges::none_of(datasets, &ScoredDataset::headline))
        return std::nullopt; // all are in the summary
    std::erase_if(datasets, [](const ScoredDataset &dataset) { return dataset.headline; });
    Table table = untuned_table(results, datasets);
    table.id = "summary-others";
    table.title = "Short clips and synthetic rooms";
    table.explanation = "The same of recordings of fewer than 30 frames and of what was rendered; "
                        "none of them is in the medians above.";
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

std::optional<Table> calibration_table(const Results &results) {
    Table table{.id = "calibration",
                .title = "Expected against true error",
                .explanation = "Of afterglow with its default target. Median of true / expected "
                               "error and the share of the frames whose true error is above 1.5 x "
                               "the expected, both from the third measurement on; correlation over "
                               "all estimated frames.",
                .corner = "sequence",
                .columns = {"true / expected", "above 1.5 x expected (%)", "correlation", "frames"},
                .rows = {}};
    for (const ScoredDataset &dataset : datasets_of(results.scores)) {
        const Score *score = preset_score(results.scores, dataset.name, "default");
        if (!score)
            continue;
        const Summary &s = score->summary;
        table.rows.push_back({dataset.label(),
                              {{text_of(s.true_over_expected, 2)},
                               {text_of(s.misjudged_share, 1)},
                               {text_of(s.expected_correlation, 2)},
                               {std::to_string(s.frames)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
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
                    .explanation =
                        tables.empty()
                            ? "All systems on the same frames. Each has the setting, or "
                              "the interval, whose duty cycle comes nearest to that of "
                              "afterglow in Table III; where the two differ by more than "
                              "a quarter, both stand in brackets, the system's and "
                              "afterglow's, and the figure is in no mean or median. "
                              "Structure from motion has no TOF camera: it gives depth "
                              "at keypoints alone, scaled to fit the truth. True-depth "
                              "pose sees the truth, too."
                            : "",
                    .corner = "dataset",
                    .columns = {},
                    .rows = {}};
        std::ranges::transform(systems, std::back_inserter(table.columns), title_of);
        for (const ScoredDataset &dataset : datasets) {
            Table::Row row{dataset.label(), {}};
            for (const std::string &system : systems) {
                const Score *score = matched_score(results.scores, dataset.name, system);
                Table::Cell cell =
                    cell_of(quantity, score ? quantity.ours(score->summary) : std::nullopt,
                            dataset.family, system);
                if (score && !comparable_score(results.scores, dataset.name, system))
                    cell.ours += fmt::format(" [{:.1f}/{:.1f} %]", score->summary.duty_cycle,
                                             compared_duty_cycle(results.scores, dataset.name));
                row.cells.push_back(std::move(cell));
            }
            table.rows.push_back(std::move(row));
        }
        for (const Total &total : totals) {
            Table::Row row{total.label, {}};
            for (const std::string &system : systems)
                row.cells.push_back(
                    cell_of(quantity, total_of(total, results, quantity, system, comparable_score),
                            total.paper, system));
            table.rows.push_back(std::move(row));
        }
        tables.push_back(std::move(table));
    }
    return tables;
}

} // namespace afterglow
