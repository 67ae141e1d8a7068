// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/report/table.hpp"
#include "ipc/power_model.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

// What make_tables() is made of. Each gives nothing where its results are not there.

std::optional<Table> summary_table(const Results &results);      ///< untuned systems
std::optional<Table> flow_table(const Results &results);         ///< I
std::optional<Table> ransac_table(const Results &results);       ///< II
std::vector<Table> evaluation_tables(const Results &results);    ///< III, one for each system
std::vector<Table> comparison_tables(const Results &results);    ///< IV, one for each quantity
std::optional<Table> frame_rate_table(const Results &results);   ///< V
std::optional<Table> power_table(const Results &results);        ///< VI
std::optional<Table> stage_time_table(const Results &results);   ///< Section V-A
std::optional<Table> saving_table(const Results &results);       ///< Section VII
std::optional<Table> reprojection_table(const Results &results); ///< Section IV-C
std::optional<Table> infill_table(const Results &results);       ///< Section VIII
std::optional<Table> stage_worth_table(const Results &results);  ///< our own stages

using ChooseScore = const Score *(std::span<const Score> scores, std::string_view dataset,
                                  std::string_view system);

/// A sequence that there are scores of.
struct ScoredDataset {
    std::string name;
    std::string_view family; ///< paper::family_of(); or empty
    bool synthetic;          ///< the room, or what stands in for a dataset
    /// "TU Munich RGB-D: tum_fr1_rpy", "ICL-NUIM (synthetic stand-in)", or the name.
    std::string label() const;
};
/// Those of the paper's families first, in its order.
std::vector<ScoredDataset> datasets_of(std::span<const Score> scores);
/// In the order of systems(), then others.
std::vector<std::string> systems_of(std::span<const Score> scores);

/// The median duty cycle of a system over all datasets, percent, at its tuned_score().
std::optional<double> typical_duty_cycle(const Results &results, std::string_view system);
/// The paper's board running a system: its active power for the share of the paper's time that the
/// system takes here, idle for the rest. `tof_w` is the caller's to set. Nothing where the
/// system was not timed.
std::optional<PowerModel> power_model_of(const Results &results, std::string_view system);

std::string text_of(const std::optional<double> &value, int digits);

} // namespace afterglow
