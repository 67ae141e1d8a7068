// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"

#include <vector>

namespace afterglow {

/// Noraky & Sze 2019's Table II: `trials` random motions of 144 points seen at random, their flow
/// rounded to whole pixels as the three-step search gives it, and a fifth of their depths, flows
/// or both corrupted; how far off is the translation with and without RANSAC?
std::vector<RansacScore> simulate_ransac(int trials);

} // namespace afterglow
