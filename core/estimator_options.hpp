// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace afterglow {

/// What the estimator is made of, and its constants. The defaults are the seed paper's.
struct EstimatorOptions {
    struct Flow {
        int grid = 12;  ///< points along each side of the uniform grid
        int block = 15; ///< side of the compared block, pixels, odd
        int step = 8;   ///< first step of the three-step search, pixels; halved down to 1
    } flow;
    struct Ransac {
        int draws = 30;                ///< hypotheses drawn
        int hypothesis_iterations = 1; ///< Gauss-Newton steps on the 3 matches of a draw
        int refine_iterations = 3;     ///< Gauss-Newton steps on the inliers
        double threshold = 4;          ///< largest squared residual of an inlier, square pixels
        double min_inliers = 10;       ///< percent of the grid's points that a pose must explain
        std::uint64_t seed = 1;        ///< of the draws
    } ransac;
};

/// The named compositions: "paper". Nothing for any other name.
std::optional<EstimatorOptions> estimator_preset(std::string_view name);

} // namespace afterglow
