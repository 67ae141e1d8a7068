// SPDX-License-Identifier: Apache-2.0
#include "core/paper/published_frame.hpp"

#include <algorithm>
#include <cassert>

namespace afterglow {

PublishedFrame::PublishedFrame(const Intrinsics &camera)
    : depth_(camera.width, camera.height), confidence_(camera.width, camera.height) {
    estimate.depth = depth_;
    estimate.confidence = confidence_;
}

void PublishedFrame::begin(std::int64_t t_ns) {
    t_ns_ = t_ns;
    estimate.inliers = estimate.matches = 0;
    ++frames_since_measured_;
}

const Estimate &PublishedFrame::give_measured(DepthView depth) {
    assert(depth.same_size(depth_.view()));
    copy_pixels(depth, depth_.view());
    measured_ns_ = t_ns_;
    if (!has_depth()) {
        ++estimate.world;
        estimate.world_from_camera = Pose::identity();
    }
    world_from_measured_ = estimate.world_from_camera;
    estimate.pose = Pose::identity();
    frames_since_measured_ = 0;
    give(FrameSource::measured, measured_confidence);
    return estimate;
}

const Estimate &PublishedFrame::give_estimated() {
    estimate.world_from_camera = (world_from_measured_ * estimate.pose.inverse()).normalized();
    give(FrameSource::estimated, unknown_confidence);
    return estimate;
}

const Estimate &PublishedFrame::give_nothing() {
    std::ranges::fill(depth_.pixels(), std::uint16_t{0});
    give(FrameSource::none, no_confidence);
    return estimate;
}

void PublishedFrame::give(FrameSource source, std::uint8_t confidence) {
    const auto depth = depth_.pixels();
    const auto plane = confidence_.pixels();
    std::size_t covered = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
        covered += depth[i] != 0;
        plane[i] = depth[i] != 0 ? confidence : no_confidence;
    }
    estimate.source = source;
    estimate.tracked = source != FrameSource::none;
    const bool nothing = source == FrameSource::none;
    estimate.age_frames = nothing ? 0 : frames_since_measured_;
    estimate.age_ns = nothing ? 0 : t_ns_ - measured_ns_;
    estimate.coverage = 100 * static_cast<float>(covered) / static_cast<float>(depth.size());
    estimate.wants_measurement = nothing;
}

} // namespace afterglow
