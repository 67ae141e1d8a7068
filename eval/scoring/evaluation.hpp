// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/frame_loop.hpp"
#include "core/base/result.hpp"
#include "core/estimate.hpp"
#include "core/gate.hpp"
#include "eval/scoring/footage.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace afterglow {

/// One frame and its score.
struct FrameScore {
    std::uint64_t index = 0; ///< from 0
    std::int64_t t_ns = 0;
    bool skipped = false; ///< nobody wanted its depth map: only index, t_ns, lit and ms hold
    bool measured = false;
    bool is_empty = false; ///< there was nothing to make a depth map from: FrameSource::none
    bool lit = false;      ///< FrameResult::lit: also while the TOF camera wakes up
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
    int bad_maps = 0;    ///< maps of the TOF camera that could not be used
    int unscored = 0;    ///< published frames whose truth could not be read
    std::string problem; ///< the sentence behind the first of these; empty without
};

/// What the caller of evaluate() may want to know while it runs.
struct EvaluationHooks {
    /// Called with each published frame's number, from 0, and its estimate.
    std::function<Status(std::uint64_t index, const Estimate &estimate)> publish{};
    /// Called after each frame with their count so far; false ends the evaluation there.
    std::function<bool(int done)> progress{};
};

/// What the frame loop says of a published frame; compare() adds how true that is.
FrameScore describe(const FrameResult &frame, std::uint64_t index);

/// Adds the errors of a published depth map against the true one.
void compare(FrameScore &score, DepthView depth, DepthView truth);

/// Takes all footage through the daemon's own frame loop, with the pipeline that `make` makes and a
/// gate of that policy, and scores what it publishes. `depth_interval`: as
/// FrameLoop::want_depth_every() takes it.
Result<Evaluation> evaluate(Footage &footage, PipelineFactory make, const GatePolicy &gate,
                            const EvaluationHooks &hooks = {},
                            std::chrono::nanoseconds depth_interval = {});

} // namespace afterglow
