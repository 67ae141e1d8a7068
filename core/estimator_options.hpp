// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/keyframe_options.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace afterglow {

/// Which of the two pipelines makes depth.
enum class Method : std::uint8_t {
    paper = 0,    ///< Noraky & Sze 2019's: sparse flow from the previous image
                  ///< (core/paper/paper_pipeline.hpp)
    keyframe = 1, ///< ours: alignment with measured keyframes (core/keyframe/keyframe_pipeline.hpp)
};

/// What the estimator is made of, and its constants. The defaults of `flow` and `ransac` are those
/// of Noraky & Sze 2019.
struct EstimatorOptions {
    Method method = Method::keyframe;
    // Of Method::paper.
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
    KeyframeOptions keyframe; ///< of Method::keyframe
};

/// The named compositions: "default" and "paper". Nothing for any other name.
std::optional<EstimatorOptions> estimator_preset(std::string_view name);

} // namespace afterglow
