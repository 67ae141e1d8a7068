// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/estimator_options.hpp"
#include "core/paper/match.hpp"

#include <Eigen/Core>

#include <vector>

namespace afterglow {

// What Noraky & Sze 2019's Table I times beside find_three_step_flow() of core/paper/grid_flow.hpp.

/// The same by pyramidal Lucas-Kanade (OpenCV), block x block windows on 3 levels. Points that it
/// loses are removed.
void find_lucas_kanade_flow(const EstimatorOptions::Flow &options, LumaView previous, LumaView next,
                            std::vector<Match> &matches);

/// At most `most` corners, pixels, by Harris' measure (OpenCV), strongest first.
std::vector<Eigen::Vector2f> find_harris_corners(LumaView image, int most);

} // namespace afterglow
