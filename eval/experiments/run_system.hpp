// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/gate.hpp"
#include "eval/baselines/systems.hpp"
#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"
#include "eval/scoring/evaluation.hpp"

#include <functional>
#include <optional>

namespace afterglow {

/// What a system runs with.
struct Tuned {
    EstimatorOptions estimator;
    GatePolicy gate;
};
/// The setting of a system by default, chosen for no dataset.
Setting own_setting(const SystemDescription &system);
/// `setting` must be one that the system has.
Tuned tuned(const SystemDescription &system, const Setting &setting);

/// The time that a frame of this system takes, in frames of the paper's system; an estimate, for
/// progress bars and to begin with the longest.
int work_of(const SystemDescription &system);

/// Called with each frame's number, from 0, and its estimate.
using OnEstimate = std::function<void(std::size_t index, const Estimate &estimate)>;

/// Takes a sequence through the daemon's frame loop with a system's pipeline and gate, and scores
/// what it publishes. Nothing when Ctrl-C stopped it.
std::optional<Evaluation> run_system(const Sequence &sequence, const SystemDescription &system,
                                     const Tuned &tuned, WorkerPool &pool, Watch &watch,
                                     const OnEstimate &on_estimate = {});

} // namespace afterglow
