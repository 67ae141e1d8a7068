// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/estimator_options.hpp"
#include "core/paper/match.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// Noraky & Sze 2019's Algorithm 1, adaptive pose estimation.
///
/// Draws three matches at a time, solves for the pose they give, and collects the matches that it
/// explains to within the threshold. Of the inlier sets large enough, the one of lowest mean
/// residual is kept, and the pose solved again from all of it. Reproducible for a given seed and
/// sequence of calls. solve() allocates nothing for up to `flow_estimates` matches.
class RansacPose {
public:
    /// `flow_estimates`: how many points flow is estimated at. Those without depth make no match,
    /// but count when it is asked whether a pose explains enough of them.
    RansacPose(const EstimatorOptions::Ransac &options, std::size_t flow_estimates);

    struct Solution {
        Pose pose;
        int inliers;
    };
    /// Nothing when no candidate stands: the signal to use the TOF camera.
    std::optional<Solution> solve(std::span<const Match> matches, const Intrinsics &camera);

private:
    /// A number in [0, bound), from a generator with the same answers on every platform.
    std::size_t draw(std::size_t bound);
    /// Gathers the inliers of `pose` and returns their mean squared residual.
    double collect_inliers(std::span<const Match> matches, const Intrinsics &camera,
                           const Pose &pose);

    EstimatorOptions::Ransac options_;
    double min_size_; ///< of an inlier set
    std::uint64_t random_;
    std::vector<Match> inliers_;
    std::vector<Match> best_;
};

} // namespace afterglow
