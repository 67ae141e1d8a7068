// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/report/table.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afterglow {

// What make_tables() is made of. Each gives nothing where its results are not there.

std::optional<Table> summary_table(const Results &results);       ///< untuned systems
std::optional<Table> other_summary_table(const Results &results); ///< short clips, rooms
std::optional<Table> calibration_table(const Results &results);   ///< expected and true error
std::optional<Table> flow_table(const Results &results);          ///< I
std::optional<Table> ransac_table(const Results &results);        ///< II
std::vector<Table> evaluation_tables(const Results &results);     ///< III, one for each system
std::vector<Table> comparison_tables(const Results &results);     ///< IV, one for each quantity
std::optional<Table> frame_rate_table(const Results &results);    ///< V
std::optional<Table> power_table(const Results &results);         ///< VI
std::optional<Table> stage_time_table(const Results &results);    ///< Section V-A
std::optional<Table> saving_table(const Results &results);        ///< Section VII
std::optional<Table> reprojection_table(const Results &results);  ///< Section IV-C
std::optional<Table> infill_table(const Results &results);        ///< Section VIII
std::optional<Table> stage_worth_table(const Results &results);   ///< our own stages

using ChooseScore = const Score *(std::span<const Score> scores, std::string_view dataset,
                                  std::string_view system);

/// Headline figures are over such: a recording of at least 30 frames.
bool is_headline(const Summary &summary);

/// A sequence that there are scores of.
struct ScoredDataset {
    std::string name;
    std::string_view family; ///< paper::family_of(); or empty
    bool synthetic;          ///< the room, or what stands in for a dataset
    bool headline;           ///< is_headline()
    /// "TU Munich RGB-D: tum_fr1_rpy", "ICL-NUIM (synthetic stand-in)", or the name.
    std::string label() const;
};
/// Those of the paper's families first, in its order.
std::vector<ScoredDataset> datasets_of(std::span<const Score> scores);
/// In the order of systems(), then others.
std::vector<std::string> systems_of(std::span<const Score> scores);

/// Of `datasets` those over which headline figures are; all, where there is none.
std::vector<ScoredDataset> headline_of(std::vector<ScoredDataset> datasets);

/// The median duty cycle of a system over headline_of(), percent, at its tuned_score().
std::optional<double> typical_duty_cycle(const Results &results, std::string_view system);

/// What processor and memory take besides the TOF camera, watts.
struct ProcessingPower {
    double lit_w;  ///< in frames that are lit
    double dark_w; ///< in frames that are not
    /// Eq. 9 of Noraky & Sze 2019. `duty_cycle`: percent.
    double system_w(double duty_cycle, double tof_w) const {
        return duty_cycle / 100 * (tof_w + lit_w) + (1 - duty_cycle / 100) * dark_w;
    }
};
/// Of the paper's system as its Eq. 9 has it. Of another: the paper's board, busy for the share of
/// the paper's CPU time that the system was measured to use and idle for the rest: that of measured
/// frames in lit ones, that of estimates in dark ones. Nothing where the CPU time was not measured.
std::optional<ProcessingPower> processing_power(const Results &results, std::string_view system);

/// Stands beside every figure of power.
inline constexpr const char *what_is_charged =
    "Charged are, in watts: the TOF camera's power for the share of the frames that are lit; of "
    "This Work as in Eq. 9 the paper's board, busy (0.63 + 0.06) in dark frames and idle "
    "(0.16 + 0.03) in lit ones; of afterglow that board busy for as long as the CPU time measured "
    "here is, of all threads and relative to an estimate of This Work, for a measured frame in lit "
    "frames and for an estimate in dark ones, and idle for the rest. "
    "The watts are the paper's, read from its board; no meter was read here. The image camera is "
    "not charged.";

std::string text_of(const std::optional<double> &value, int digits);

} // namespace afterglow
