// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/estimate.hpp"
#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "core/base/result.hpp"
#include "eval/scoring/footage.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace afterglow {

/// One published frame and its score.
struct FrameScore {
    std::uint64_t index = 0; ///< of the published frames, from 0
    std::int64_t t_ns = 0;
    bool measured = false;
    std::uint32_t age_frames = 0;
    int inliers = 0;
    std::optional<double> expected_mre; ///< percent, where the preset predicts it
    std::optional<double> mre;          ///< percent; nothing without a pixel to compare
    double mae_cm = 0;                  ///< holds where `mre` does, as does the next
    double rmse_cm = 0;
    std::optional<double> coverage; ///< percent; nothing where the truth is not known
    double ms = 0;                  ///< track() and measure() of this frame
};

struct Evaluation {
    std::vector<FrameScore> frames;
    int damaged = 0;     ///< frames of the footage that were dropped as unusable
    int unscored = 0;    ///< published frames whose truth could not be read
    std::string problem; ///< the sentence behind the first of either; empty without
};

struct EvaluationOptions {
    EstimatorOptions estimator;
    GatePolicy gate;
    bool oracle = false; ///< the pose is refined on the true depth (oracle.hpp)
    int workers = 2;
    /// Called with each published frame's number among the footage's and its depth map.
    std::function<Status(std::uint64_t index, DepthView depth)> publish;
    std::function<void(int done)> progress; ///< called after each frame
};

/// What an estimate says of itself; compare() adds how true that is.
FrameScore describe(const Estimate &estimate, std::uint64_t index, std::int64_t t_ns, double ms);

/// Fills in the score of a published depth map against the truth.
void compare(FrameScore &score, DepthView depth, DepthView truth);

/// Takes all footage the way of a frame, with the daemon's own loop, and scores what it publishes.
Result<Evaluation> evaluate(Footage &footage, const EvaluationOptions &options);

} // namespace afterglow
