// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/run_system.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"
#include "eval/scoring/footage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace afterglow {

std::vector<Table> make_tables(const Results &results) {
    std::vector<Table> tables;
    const auto add = [&](auto made) {
        for (Table &table : made)
            tables.push_back(std::move(table));
    };
    const auto add_one = [&](std::optional<Table> table) {
        if (table)
            tables.push_back(*std::move(table));
    };
    add_one(summary_table(results));
    add_one(other_summary_table(results));
    add_one(calibration_table(results));
    add_one(flow_table(results));
    add_one(ransac_table(results));
    add(evaluation_tables(results));
    add(comparison_tables(results));
    add_one(frame_rate_table(results));
    add_one(power_table(results));
    add_one(stage_time_table(results));
    add_one(saving_table(results));
    add_one(reprojection_table(results));
    add_one(infill_table(results));
    add_one(stage_worth_table(results));
    return tables;
}

std::string ScoredDataset::label() const {
    if (family.empty())
        return name;
    if (synthetic)
        return fmt::format("{} (synthetic stand-in)", paper::family_title(family));
    return fmt::format("{}: {}", paper::family_title(family), name);
}

bool is_headline(const Summary &summary) {
    return !is_synthetic(summary.dataset) && summary.frames >= 30;
}

std::vector<ScoredDataset> datasets_of(std::span<const Score> scores) {
    std::vector<ScoredDataset> all;
    for (const Score &score : scores) {
        const std::string &name = score.summary.dataset;
        if (std::ranges::find(all, name, &ScoredDataset::name) == all.end())
            all.push_back({name, paper::family_of(name, score.layout), is_synthetic(name),
                           is_headline(score.summary)});
    }
    // What is of no family has the rank behind the last one.
    std::ranges::stable_sort(all, {}, [](const ScoredDataset &dataset) {
        return std::ranges::find(paper::families(), dataset.family) - paper::families().begin();
    });
    return all;
}

std::vector<ScoredDataset> headline_of(std::vector<ScoredDataset> datasets) {
    std::vector<ScoredDataset> headline;
    std::ranges::copy_if(datasets, std::back_inserter(headline), &ScoredDataset::headline);
    return headline.empty() ? datasets : headline;
}

std::vector<std::string> systems_of(std::span<const Score> scores) {
    std::vector<std::string> names;
    for (const SystemDescription &system : systems())
        if (std::ranges::any_of(scores,
                                [&](const Score &s) { return s.summary.preset == system.name; }))
            names.emplace_back(system.name);
    for (const Score &score : scores) // and those that others have brought
        if (std::ranges::find(names, score.summary.preset) == names.end())
            names.push_back(score.summary.preset);
    return names;
}

std::string text_of(const std::optional<double> &value, int digits) {
    return value ? fmt::format("{:.{}f}", *value, digits) : "";
}

} // namespace afterglow
