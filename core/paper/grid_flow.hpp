// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/estimator_options.hpp"
#include "core/paper/match.hpp"

#include <vector>

namespace afterglow {

/// Flow on a uniform grid (Noraky & Sze 2019, Section IV-A), in two steps, so that another way to
/// find flow can take the place of the second. Neither allocates once `matches` has its capacity.

/// Makes `matches` the grid's points that have depth in `depth`, and around them a block inside
/// the image, not yet moved: `to` equals `from`.
void place_grid(const EstimatorOptions::Flow &options, DepthView depth,
                std::vector<Match> &matches);

/// Moves every `to` to where the block around `from` went, by three-step search. `from` as
/// place_grid() makes it.
void find_three_step_flow(const EstimatorOptions::Flow &options, LumaView previous, LumaView next,
                          std::vector<Match> &matches);

} // namespace afterglow
