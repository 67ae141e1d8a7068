// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/json.hpp"
#include "eval/scoring/summary.hpp"

namespace afterglow {

/// A Summary as a JSON object whose keys, which are stable, are the names of its members. A key
/// that is missing when it is read leaves its member as it is by default.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Summary, dataset, preset, frames, lit, measured,
                                                damaged, bad_maps, unscored, duty_cycle,
                                                measured_share, mre_median, mre_mean, mre_p95,
                                                mae_cm_median, rmse_cm_median, coverage_median,
                                                coverage_p5, expected_correlation,
                                                true_over_expected, misjudged_share,
                                                frames_over_target, ms_per_frame_median)

} // namespace afterglow
