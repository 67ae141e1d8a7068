// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "afterglow/afterglow.h"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "eval/scoring/evaluation.hpp"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace afterglow {

/// A frame as a reader got it.
struct LiveFrame {
    LiveFrame(int width, int height) : luma(width, height), depth(width, height) {
        info.size = sizeof info;
    }
    afterglow_frame info{};
    Luma luma;
    DepthMap depth;
    std::int64_t received_ns = 0; ///< CLOCK_MONOTONIC
};

/// An estimated frame, what it was made from, and what it should be.
struct LiveExample {
    Luma luma;
    DepthMap measured; ///< the map that was warped
    DepthMap estimated;
    DepthMap truth;
    std::uint32_t age_frames = 0;
    double mre = 0;      ///< percent
    double coverage = 0; ///< percent
};

struct LiveScore {
    Evaluation evaluation;
    std::uint64_t images = 0;           ///< that the camera took, until the last frame
    std::vector<double> latency_ms;     ///< from image to reader
    std::optional<LiveExample> example; ///< the oldest estimate of no more than typical error
};

/// Scores frames in a thread of its own, so that the reader is never late for the next one.
class LiveScorer {
public:
    using Truth = std::function<Result<DepthMap>(std::uint64_t sequence)>;
    explicit LiveScorer(Truth truth);
    ~LiveScorer();

    void add(LiveFrame frame);
    /// Waits for the last score. Called once.
    LiveScore finish();

private:
    void work();
    void score(LiveFrame &frame);
    /// No worse than the median of the estimates so far.
    bool is_typical(const FrameScore &frame);
    void join();

    Truth truth_;
    LiveScore score_;
    DepthMap measured_;
    std::vector<double> errors_; ///< of the estimates so far, percent
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<LiveFrame> waiting_;
    bool finishing_ = false;
    std::thread thread_;
};

} // namespace afterglow
