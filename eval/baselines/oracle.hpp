// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/keyframe/depth_composer.hpp"
#include "core/keyframe/depth_surface.hpp"
#include "core/estimate.hpp"
#include "core/estimator.hpp"
#include "core/estimator_options.hpp"
#include "core/gate.hpp"
#include "core/keyframe/keyframe.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/worker_pool.hpp"
#include "capture/frame_loop.hpp"
#include "drivers/source.hpp"
#include "eval/scoring/footage.hpp"

#include <chrono>
#include <cstdint>
#include <string>

namespace afterglow {

/// What no real system can do: the pose of each image is refined on the true depth of that image,
/// and the error that it expects is the true one. What error is left is not the pose's: noise of
/// the sensor, occlusion, depth that was never measured.
///
/// Starts from the pose that an Estimator of the same options tracks, and gives that one's map
/// where it is the better of the two. track() and measure() otherwise as Estimator's.
class Oracle {
public:
    Oracle(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool);

    /// `truth`: the true depth of the image `luma`.
    const Estimate &track(LumaView luma, std::int64_t t_ns, DepthView truth);
    const Estimate &measure(DepthView depth);

private:
    bool refine(const Pose &tracked);

    Intrinsics camera_;
    KeyframeOptions options_;
    WorkerPool &pool_;
    Estimator estimator_;
    KeyframeSet keyframes_;
    DepthSurface truth_;
    DepthComposer composer_;
    Pose now_; ///< world (the first measured frame) to camera
    Estimate estimate_;
};

/// FrameLoop's way of a frame, with the Oracle in the Estimator's place: the gate acts on the true
/// error and coverage.
class OracleLoop {
public:
    /// All must outlive the loop.
    OracleLoop(Footage &footage, const EstimatorOptions &estimator, const GatePolicy &gate,
               WorkerPool &pool);

    Status start();
    void stop();
    FrameResult step(std::chrono::nanoseconds timeout);

private:
    bool read_paired();
    void light(bool lit, FrameResult &result);

    Footage &footage_;
    Oracle oracle_;
    Gate gate_;
    ColorFrame color_;
    DepthFrame depth_;
    std::string problem_;
};

} // namespace afterglow
