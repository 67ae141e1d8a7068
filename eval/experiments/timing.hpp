// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// Collects the times of things that are done in turn, round by round, so that whatever else the
/// machine does slows all of them alike, and compares them within each round.
class Stopwatches {
public:
    /// The reference is that of these names which others are divided by.
    Stopwatches(std::vector<std::string> names, const std::string &reference);

    /// The time of each, in the order of the names; negative: it had nothing to do in this round,
    /// and the round does not count for it.
    void add_round(const std::vector<double> &ms);
    /// Those with at least one round.
    std::vector<Timing> timings() const;
    /// Rounds that count, of the one with the fewest.
    int rounds() const;

private:
    std::vector<std::string> names_;
    std::size_t reference_;
    std::vector<std::vector<double>> ms_;
    std::vector<std::vector<double>> ratios_;
};

/// Medians are of no fewer rounds than this.
inline constexpr int least_rounds = 30;

/// Table I: flow at the paper's grid by three-step search and Lucas-Kanade, and Harris corners, on
/// the same images, on one thread.
std::vector<Timing> time_flow(const Sequence &sequence, Watch &watch);

/// The work of time_flow() and time_stages().
double stages_work();

struct SystemTimes {
    std::vector<Timing> estimates; ///< time of a frame's estimate
    std::vector<Timing> cpu;       ///< CPU time of all threads for such a frame
    /// The same for a measured frame; the ratios are to an estimate of the paper's system.
    std::vector<Timing> measured_cpu;
};
/// Table V: a frame's estimate by every system, on the same frames; without `baselines` only by the
/// paper's and afterglow. Measured frames count for measured_cpu alone.
SystemTimes time_systems(const Sequence &sequence, bool baselines, int workers, Watch &watch);

/// The work of that.
double systems_work(bool baselines);

/// The run-time breakdown of the paper's system: flow, pose, reprojection; the reference is the
/// sum, "all".
std::vector<Timing> time_stages(const Sequence &sequence, int workers, Watch &watch);

} // namespace afterglow
