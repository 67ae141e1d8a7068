// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/evaluation.hpp"

#include "eval/scoring/metrics.hpp"
#include "capture/frame_loop.hpp"
#include "eval/baselines/oracle.hpp"

#include <chrono>

namespace afterglow {
namespace {

/// Takes all footage through a FrameLoop or its like.
template <class Loop>
Result<Evaluation> take(Footage &footage, const EvaluationOptions &options, Loop &&loop) {
    if (const Status started = loop.start(); !started)
        return started.error();
    Evaluation evaluation;
    evaluation.damaged = footage.left_out;
    evaluation.problem = footage.problem;
    const auto note = [&](int &counter, std::string_view problem) {
        ++counter;
        if (evaluation.problem.empty())
            evaluation.problem = problem;
    };
    for (int done = 1;; ++done) {
        const FrameResult result = loop.step(std::chrono::seconds(1));
        if (result.capture == Capture::ended)
            break;
        if (result.capture == Capture::lost)
            return Error{std::string(result.problem)};
        if (result.capture == Capture::damaged || result.tof == Capture::damaged)
            note(evaluation.damaged, result.problem);
        if (options.progress)
            options.progress(done);
        if (result.capture != Capture::frame)
            continue;
        const double ms = std::chrono::duration<double, std::milli>(result.estimation_time).count();
        FrameScore &frame = evaluation.frames.emplace_back(
            describe(result.estimate, evaluation.frames.size(), result.t_ns, ms));
        if (options.publish)
            if (Status published = options.publish(frame.index, result.estimate.depth); !published)
                return published.error();
        const auto truth = footage.truth(result.sequence);
        if (truth)
            compare(frame, result.estimate.depth, *truth);
        else
            note(evaluation.unscored, truth.error().message);
    }
    loop.stop();
    return evaluation;
}

} // namespace

FrameScore describe(const Estimate &estimate, std::uint64_t index, std::int64_t t_ns, double ms) {
    FrameScore score;
    score.index = index;
    score.t_ns = t_ns;
    score.measured = estimate.source == FrameSource::measured;
    score.age_frames = estimate.age_frames;
    score.inliers = estimate.inliers;
    score.ms = ms;
    if (estimate.expected_mre >= 0)
        score.expected_mre = estimate.expected_mre;
    return score;
}

void compare(FrameScore &score, DepthView depth, DepthView truth) {
    const DepthErrors errors = compare_depth(depth, truth);
    score.mae_cm = errors.mae_cm;
    score.rmse_cm = errors.rmse_cm;
    if (errors.pixels > 0)
        score.mre = errors.mre;
    if (errors.true_pixels > 0)
        score.coverage = errors.coverage();
}

Result<Evaluation> evaluate(Footage &footage, const EvaluationOptions &options) {
    WorkerPool pool(options.workers);
    if (options.oracle)
        return take(footage, options, OracleLoop(footage, options.estimator, options.gate, pool));
    return take(footage, options, FrameLoop(footage.rig, options.estimator, options.gate, pool));
}

} // namespace afterglow
