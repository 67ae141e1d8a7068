// SPDX-License-Identifier: Apache-2.0
#include "core/paper/paper_pipeline.hpp"

#include "core/paper/grid_flow.hpp"

#include <cassert>

namespace afterglow {
namespace {

std::size_t grid_points(const EstimatorOptions &options) {
    return static_cast<std::size_t>(options.flow.grid) *
           static_cast<std::size_t>(options.flow.grid);
}

} // namespace

PaperPipeline::PaperPipeline(const EstimatorOptions &options, const Intrinsics &camera,
                             WorkerPool &pool)
    : options_(options), camera_(camera), ransac_(options.ransac, grid_points(options)),
      reprojection_(camera, pool), previous_luma_(camera.width, camera.height),
      measured_(camera.width, camera.height), frame_(camera) {
    matches_.reserve(grid_points(options));
}

void PaperPipeline::find_flow(LumaView previous, LumaView next, std::vector<Match> &matches) {
    find_three_step_flow(options_.flow, previous, next, matches);
}

std::optional<RansacPose::Solution> PaperPipeline::find_motion(std::span<const Match> matches) {
    return ransac_.solve(matches, camera_);
}

void PaperPipeline::reproject(DepthView measured, const Pose &pose,
                              ImageView<std::uint16_t> depth) {
    reprojection_.warp(measured, pose, depth);
}

const Estimate &PaperPipeline::track(LumaView luma, std::int64_t t_ns) {
    assert(luma.same_size(previous_luma_.view()));
    Estimate &e = frame_.estimate;
    frame_.begin(t_ns);
    const bool following = frame_.has_depth();
    if (following) {
        place_grid(options_.flow, frame_.depth(), matches_);
        find_flow(previous_luma_, luma, matches_);
        e.matches = static_cast<int>(matches_.size());
    }
    copy_pixels(luma, previous_luma_.view());
    const auto motion = following ? find_motion(matches_) : std::nullopt;
    if (!motion) // and none until the next measurement: poses are composed without gaps
        return frame_.give_nothing();
    e.pose = (motion->pose * e.pose).normalized();
    e.inliers = motion->inliers;
    reproject(measured_, e.pose, frame_.depth());
    return frame_.give_estimated();
}

const Estimate &PaperPipeline::measure(const Measurement &measurement) {
    const DepthView depth = measurement.depth;
    assert(depth.same_size(measured_.view()));
    copy_pixels(depth, measured_.view());
    return frame_.give_measured(depth);
}

} // namespace afterglow
