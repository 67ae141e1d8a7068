// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/scoring/summary.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace afterglow {

// The results of the experiments. A report prints these and the figures of the paper
// (eval/report/paper_figures.hpp), nothing else.

/// The parameter that was varied to trade duty cycle for error.
struct Setting {
    std::string
        name; ///< "threshold", "target" or "interval"; empty: the system has no such parameter
    double value = 0;
};

/// A system on a dataset with a setting. `summary.preset` is the system's name.
struct Score {
    Setting setting;
    Summary summary;
    std::string layout;                ///< of the dataset; empty where it is not known
    std::string footage{};             ///< which frames, as `run --json` says; empty: not known
    ExpectedAgainstTrue calibration{}; ///< of afterglow with its default target alone
};

/// The run time of one algorithm, and its ratio to a reference that was timed in turn with it.
struct Timing {
    std::string name;
    double ms = 0;                     ///< median
    double ratio = 0;                  ///< to the reference of the same round, median
    double ratio_q1 = 0, ratio_q3 = 0; ///< quartiles of the same
    int rounds = 0;
};

/// Table II: error of the pose with and without RANSAC when `depth` or `flow` are corrupted.
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

/// A picture, and the colour scale that explains it.
struct Picture {
    enum class Colors : std::uint8_t {
        none,  ///< a camera's image
        depth, ///< color_scale() from `from` to `to`, metres
        error, ///< error_color() from `from` to `to`, percent
    };
    std::string group; ///< pictures of one group stand side by side
    std::string caption;
    std::string png; ///< png_data()
    Colors colors = Colors::none;
    double from = 0;
    double to = 0;
};

struct Results {
    bool complete = true;           ///< false: the work was stopped early
    std::string version;            ///< of afterglow; this and the next two: empty if not known
    std::string machine;            ///< CPU model on which the run times were taken
    std::string date;               ///< when the work began, UTC
    std::vector<std::string> notes; ///< what a reader should know of the data
    std::vector<Score> scores;
    std::vector<Timing> flow_times;   ///< Table I; the reference is the three-step search
    std::vector<Timing> system_times; ///< Table V; the reference is the paper's system
    /// CPU time of all threads for a frame that is estimated; the reference is the paper's system.
    std::vector<Timing> system_cpu_times;
    /// The same for a frame that is measured; the reference is an estimate of the paper's system.
    std::vector<Timing> measured_cpu_times;
    std::vector<Timing> stage_times; ///< of the paper's system; the reference is their sum
    std::vector<RansacScore> ransac;
    std::vector<Ablation> ablations; ///< by dataset; of each "default" comes first
    std::vector<InfillScore> infill;
    std::vector<Picture> pictures;
};

} // namespace afterglow
