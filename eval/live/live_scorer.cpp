// SPDX-License-Identifier: Apache-2.0
#include "eval/live/live_scorer.hpp"

#include "eval/scoring/summary.hpp"

#include <utility>

namespace afterglow {

LiveScorer::LiveScorer(Truth truth) : truth_(std::move(truth)), thread_([this] { work(); }) {}

LiveScorer::~LiveScorer() {
    join();
}

void LiveScorer::add(LiveFrame frame) {
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back(std::move(frame));
    }
    changed_.notify_one();
}

LiveScore LiveScorer::finish() {
    join();
    return std::move(score_);
}

void LiveScorer::join() {
    if (!thread_.joinable())
        return;
    {
        const std::lock_guard lock(mutex_);
        finishing_ = true;
    }
    changed_.notify_one();
    thread_.join();
}

void LiveScorer::work() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] { return finishing_ || !waiting_.empty(); });
        if (waiting_.empty())
            return;
        LiveFrame frame = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        score(frame);
        lock.lock();
    }
}

bool LiveScorer::is_typical(const FrameScore &frame) {
    if (!frame.mre)
        return false;
    errors_.push_back(*frame.mre);
    return *frame.mre <= *percentile(errors_, 50);
}

void LiveScorer::score(LiveFrame &frame) {
    score_.latency_ms.push_back(static_cast<double>(frame.received_ns - frame.info.t_ns) / 1e6);
    FrameScore &scored = score_.evaluation.frames.emplace_back();
    scored.index = frame.info.index;
    scored.t_ns = frame.info.t_ns;
    scored.measured = frame.info.source == AFTERGLOW_MEASURED;
    scored.lit = frame.info.emitter == AFTERGLOW_EMITTER_ON;
    scored.age_frames = frame.info.age_frames;
    scored.inliers = static_cast<int>(frame.info.inliers);
    if (frame.info.expected_mre >= 0)
        scored.expected_mre = frame.info.expected_mre;
    score_.images = frame.info.sequence + 1;
    if (scored.measured)
        measured_ = frame.depth;
    auto truth = truth_(frame.info.sequence);
    if (!truth) {
        ++score_.evaluation.unscored;
        return;
    }
    compare(scored, frame.depth, *truth);
    if (!scored.measured && is_typical(scored) && !measured_.empty() &&
        (!score_.example || scored.age_frames > score_.example->age_frames))
        score_.example = LiveExample{
            std::move(frame.luma), measured_,   std::move(frame.depth), *std::move(truth),
            scored.age_frames,     *scored.mre, *scored.coverage};
}

} // namespace afterglow
