// SPDX-License-Identifier: Apache-2.0
#include "core/estimator.hpp"

#include "core/match.hpp"
#include "core/ransac.hpp"
#include "core/reprojection.hpp"
#include "core/three_step_search.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

namespace afterglow {

std::optional<EstimatorOptions> estimator_preset(std::string_view name) {
    if (name == "paper")
        return EstimatorOptions{};
    return std::nullopt;
}

/// The seed paper's pipeline: flow on a grid from the previous image, pose from the flow and the
/// previous depth map, composed since the last measured map (Eq. 8), which is reprojected.
struct Estimator::State {
    State(const EstimatorOptions &o, const Intrinsics &c, WorkerPool &pool)
        : options(o), camera(c), ransac(o.ransac, static_cast<std::size_t>(o.flow.grid) *
                                                      static_cast<std::size_t>(o.flow.grid)),
          reprojection(c, pool), previous_luma(c.width, c.height), measured(c.width, c.height),
          depth(c.width, c.height), confidence(c.width, c.height) {
        matches.reserve(static_cast<std::size_t>(o.flow.grid) *
                        static_cast<std::size_t>(o.flow.grid));
        estimate.depth = depth;
        estimate.confidence = confidence;
    }

    void find_matches(LumaView luma);
    void publish(FrameSource source, std::uint8_t depth_confidence);
    void give_up();

    EstimatorOptions options;
    Intrinsics camera;
    RansacPose ransac;
    ForwardReprojection reprojection;
    Luma previous_luma;
    DepthMap measured;
    std::int64_t measured_ns = 0;
    std::int64_t t_ns = 0;
    std::vector<Match> matches;
    DepthMap depth; ///< the previous map while matching, the new one after
    Image<std::uint8_t> confidence;
    Estimate estimate;
};

/// Flow from the previous image at the points of a uniform grid that have depth.
void Estimator::State::find_matches(LumaView luma) {
    const auto &[grid, block, step] = options.flow;
    matches.clear();
    for (int j = 0; j < grid; ++j) {
        for (int i = 0; i < grid; ++i) {
            const int u = (2 * i + 1) * camera.width / (2 * grid);
            const int v = (2 * j + 1) * camera.height / (2 * grid);
            const int margin = block / 2;
            if (u < margin || v < margin || u + margin >= camera.width ||
                v + margin >= camera.height || depth(u, v) == 0)
                continue;
            const Displacement flow = three_step_search(previous_luma, luma, u, v, block, step);
            matches.push_back(
                {.from = {u, v}, .to = {u + flow.du, v + flow.dv}, .z = depth(u, v) / 1000.0});
        }
    }
}

/// Fills in what follows from the depth map.
void Estimator::State::publish(FrameSource source, std::uint8_t depth_confidence) {
    const auto pixels = depth.pixels();
    const auto planes = confidence.pixels();
    std::size_t covered = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        covered += pixels[i] != 0;
        planes[i] = pixels[i] != 0 ? depth_confidence : 0;
    }
    estimate.coverage = 100 * static_cast<float>(covered) / static_cast<float>(pixels.size());
    estimate.source = source;
    estimate.age_ns = source == FrameSource::none ? 0 : t_ns - measured_ns;
}

/// No pose, no depth; and none until the next measurement, for poses are composed without gaps.
void Estimator::State::give_up() {
    std::ranges::fill(depth.pixels(), std::uint16_t{0});
    publish(FrameSource::none, 0);
    estimate.wants_measurement = true;
}

Estimator::Estimator(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool)
    : state_(std::make_unique<State>(options, camera, pool)) {}
Estimator::~Estimator() = default;
Estimator::Estimator(Estimator &&) noexcept = default;

const Estimate &Estimator::track(LumaView luma, std::int64_t t_ns) {
    State &s = *state_;
    Estimate &e = s.estimate;
    assert(luma.same_size(s.previous_luma.view()));
    s.t_ns = t_ns;
    e.inliers = e.matches = 0;
    const bool following = e.source != FrameSource::none;
    if (following) {
        s.find_matches(luma);
        ++e.age_frames;
        e.matches = static_cast<int>(s.matches.size());
    }
    for (int v = 0; v < luma.height(); ++v)
        std::copy_n(luma.row(v), luma.width(), s.previous_luma.row(v));
    const auto motion = following ? s.ransac.solve(s.matches, s.camera) : std::nullopt;
    if (!motion) {
        s.give_up();
        return e;
    }
    e.pose = motion->pose * e.pose;
    e.inliers = motion->inliers;
    s.reprojection.warp(s.measured, e.pose, s.depth);
    s.publish(FrameSource::estimated, static_cast<std::uint8_t>(255 * motion->inliers / e.matches));
    e.wants_measurement = false;
    return e;
}

const Estimate &Estimator::measure(DepthView depth) {
    State &s = *state_;
    assert(depth.same_size(s.measured.view()));
    for (int v = 0; v < depth.height(); ++v)
        std::copy_n(depth.row(v), depth.width(), s.measured.row(v));
    s.measured_ns = s.t_ns;
    std::ranges::copy(s.measured.pixels(), s.depth.pixels().begin());
    s.estimate.pose = Pose::identity();
    s.estimate.age_frames = 0;
    s.publish(FrameSource::measured, 255);
    s.estimate.wants_measurement = false;
    return s.estimate;
}

} // namespace afterglow
