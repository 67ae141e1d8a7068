// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/power_model.hpp"
#include "tools/eval/report/results.hpp"
#include "tools/eval/report/table.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

// What make_tables() is made of. Each gives nothing where its results are not there.

std::optional<Table> flow_table(const Results &results);       ///< I
std::optional<Table> ransac_table(const Results &results);     ///< II
std::optional<Table> evaluation_table(const Results &results); ///< III
std::vector<Table> comparison_tables(const Results &results);  ///< IV, one for each quantity
std::optional<Table> frame_rate_table(const Results &results); ///< V
std::optional<Table> power_table(const Results &results);      ///< VI
std::optional<Table> saving_table(const Results &results);     ///< Section VI
std::optional<Table> stage_table(const Results &results);      ///< Section V-A
std::optional<Table> ablation_table(const Results &results);   ///< Section IV-C
std::optional<Table> infill_table(const Results &results);     ///< Section VII

using ChooseScore = const Score *(std::span<const Score> scores, std::string_view dataset,
                                  std::string_view system);

/// In the order in which they first appear.
std::vector<std::string> datasets_of(std::span<const Score> scores);
/// In the order of lineup(), then others.
std::vector<std::string> systems_of(std::span<const Score> scores);

/// The median duty cycle of a system over all datasets, percent, at its tuned_score().
std::optional<double> typical_duty_cycle(const Results &results, std::string_view system);
/// The paper's board running a system: its measured power, the active part shrunk to the share of
/// the paper's time that the system takes here. `tof_w` is the caller's to set. Nothing where the
/// system was not timed.
std::optional<PowerModel> power_model_of(const Results &results, std::string_view system);

std::string text_of(const std::optional<double> &value, int digits);

} // namespace afterglow
