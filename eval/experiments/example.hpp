// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"

#include <span>
#include <vector>

namespace afterglow {

/// One frame of a sequence as a row of pictures: the image, its true depth, and for "paper" and
/// "default", each at its matched_score() of `scores`, the depth it gave and how wrong that is. The
/// frame is the one that afterglow estimates from the oldest measurement. Empty where neither has a
/// score.
std::vector<Picture> example(const Sequence &sequence, std::span<const Score> scores, int workers,
                             Watch &watch);

/// The work of that for each frame.
double example_work();

} // namespace afterglow
