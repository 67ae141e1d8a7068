// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/scoring/summary.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

// What the experiments found, and nothing else: everything that a report shows of ours is in here.

/// The knob that was turned to trade duty cycle for error.
struct Setting {
    std::string name; ///< "threshold", "target" or "interval"; empty: there is no knob
    double value = 0;
};

/// A system on a dataset with a setting. `summary.preset` is the system's name.
struct Score {
    Setting setting;
    Summary summary;
    std::string layout; ///< of the dataset; empty where it is not known
};

/// What something costs in time, against another thing that was timed in turn with it.
struct Timing {
    std::string name;
    double ms = 0;                     ///< median
    double ratio = 0;                  ///< to the reference of the same round, median
    double ratio_q1 = 0, ratio_q3 = 0; ///< quartiles of the same
    int rounds = 0;
};

/// Table II: what RANSAC is worth when `depth` or `flow` are corrupted.
struct RansacScore {
    bool depth = false;
    bool flow = false;
    double plain_rmse_m = 0; ///< of the translation
    double ransac_rmse_m = 0;
    double reduction() const { return 100 * (1 - ransac_rmse_m / plain_rmse_m); } ///< percent
};

/// afterglow with one of its stages switched off, on a dataset.
struct Ablation {
    std::string variant; ///< "default" has all stages
    std::string shows;   ///< what is lost
    Summary summary;
};

/// Section VIII: depth taken away from a measured map and given back from an earlier one.
struct InfillScore {
    std::string dataset;
    std::string system;
    std::string reason; ///< "out of range" or "saturation"
    int trials = 0;
    std::optional<double> overlap_mre{}; ///< percent; where both maps have depth, as in the paper
    std::optional<double> filled_mre{};  ///< percent; where depth was taken away
    double filled = 0;                   ///< percent of what was taken away
};

/// A panel of a figure.
struct Picture {
    std::string group; ///< pictures of one group stand side by side
    std::string caption;
    std::string png; ///< png_data()
};

struct Results {
    bool complete = true;           ///< false: the work was stopped early
    std::vector<std::string> notes; ///< what a reader should know of the data
    std::vector<Score> scores;
    std::vector<Timing> flow_times;   ///< Table I; the reference is the three-step search
    std::vector<Timing> system_times; ///< Table V; the reference is the paper's system
    std::vector<Timing> stage_times;  ///< of the paper's system; the reference is their sum
    std::vector<RansacScore> ransac;
    std::vector<Ablation> ablations; ///< by dataset; of each "default" comes first
    std::vector<InfillScore> infill;
    std::vector<Picture> pictures;
};

} // namespace afterglow
