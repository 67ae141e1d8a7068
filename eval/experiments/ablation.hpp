// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"

#include <vector>

namespace afterglow {

/// afterglow on a sequence with each of its stages switched off in turn; the first has them all.
/// Each variant is one thread's, `workers` at a time. Empty when it was stopped.
std::vector<Ablation> ablate_sequence(const Sequence &sequence, int workers, Watch &watch);

/// The work of that for each frame.
double ablation_work();

} // namespace afterglow
