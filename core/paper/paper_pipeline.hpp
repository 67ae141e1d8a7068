// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/paper/match.hpp"
#include "core/paper/published_frame.hpp"
#include "core/paper/ransac.hpp"
#include "core/paper/reprojection.hpp"
#include "core/pipeline.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace afterglow {

/// Noraky & Sze 2019's pipeline (its Fig. 2): flow on a uniform grid from the previous image, pose
/// from the flow and the previous depth map, composed since the last measured map (Eq. 8), which
/// is reprojected.
///
/// Its three stages are virtual: the systems that the paper is compared with differ from it in
/// one of them each. As they are here, no call allocates.
class PaperPipeline : public Pipeline {
public:
    PaperPipeline(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool);
    const Estimate &track(LumaView luma, std::int64_t t_ns) override;
    const Estimate &measure(const Measurement &measurement) override;
    void restart() override { frame_.give_nothing(); }

protected:
    /// Moves `to` of every match, which comes in equal to `from`, to where that point is in the
    /// next image. Removes matches it loses. Here: three-step search.
    virtual void find_flow(LumaView previous, LumaView next, std::vector<Match> &matches);
    /// The motion that the matches tell, or nothing: the signal to use the TOF camera. Here:
    /// Algorithm 1.
    virtual std::optional<RansacPose::Solution> find_motion(std::span<const Match> matches);
    /// Draws the last measured map as seen after `pose`. Here: forward, nearest wins (Eq. 7).
    virtual void reproject(DepthView measured, const Pose &pose, ImageView<std::uint16_t> depth);

    const EstimatorOptions &options() const { return options_; }
    const Intrinsics &camera() const { return camera_; }

private:
    EstimatorOptions options_;
    Intrinsics camera_;
    RansacPose ransac_;
    ForwardReprojection reprojection_;
    Luma previous_luma_;
    DepthMap measured_;
    std::vector<Match> matches_;
    PublishedFrame frame_;
};

} // namespace afterglow
