// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/evaluation.hpp"

#include "eval/scoring/metrics.hpp"

#include <chrono>
#include <utility>

namespace afterglow {

FrameScore describe(const FrameResult &frame, std::uint64_t index) {
    const Estimate &estimate = frame.estimate;
    FrameScore score;
    score.index = index;
    score.t_ns = frame.t_ns;
    score.measured = estimate.source == FrameSource::measured;
    score.lit = frame.lit;
    score.age_frames = estimate.age_frames;
    score.inliers = estimate.inliers;
    score.ms = std::chrono::duration<double, std::milli>(frame.estimation_time).count();
    score.skipped = estimate.depth.empty();
    score.is_empty = estimate.source == FrameSource::none;
    if (!score.skipped && !score.is_empty && estimate.expected_mre >= 0)
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

Result<Evaluation> evaluate(Footage &footage, PipelineFactory make, const GatePolicy &gate,
                            const EvaluationHooks &hooks, std::chrono::nanoseconds depth_interval) {
    FrameLoop loop(footage.rig, std::move(make), gate, footage.geometry);
    loop.want_depth_every(depth_interval);
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
        const FrameResult frame = loop.step(std::chrono::seconds(1));
        if (frame.capture == Capture::ended)
            break;
        if (frame.capture == Capture::lost)
            return Error{std::string(frame.problem)};
        if (frame.capture == Capture::damaged)
            note(evaluation.damaged, frame.problem);
        else if (frame.tof == Capture::damaged)
            note(evaluation.bad_maps, frame.problem);
        if (frame.capture == Capture::frame) {
            const std::size_t index = evaluation.frames.size();
            FrameScore &score = evaluation.frames.emplace_back(describe(frame, index));
            if (!score.skipped) {
                if (const auto truth = footage.truth(frame.sequence))
                    compare(score, frame.estimate.depth, *truth);
                else
                    note(evaluation.unscored, truth.error().message);
                if (hooks.publish)
                    if (Status published = hooks.publish(index, frame.estimate); !published)
                        return published.error();
            }
        }
        if (hooks.progress && !hooks.progress(done))
            break;
    }
    loop.stop();
    return evaluation;
}

} // namespace afterglow
