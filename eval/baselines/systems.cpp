// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/systems.hpp"

#include "eval/baselines/makers.hpp"
#include "eval/baselines/oracle.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <opencv2/core/utility.hpp>

namespace afterglow {
namespace {

/// A pipeline of the daemon.
template <Method method>
std::unique_ptr<Pipeline> make_daemon_pipeline(const SystemInputs &inputs,
                                               const Intrinsics &camera) {
    EstimatorOptions options = inputs.options;
    options.method = method;
    return pipeline_factory(options, inputs.pool)(camera);
}

std::unique_ptr<Pipeline> make_oracle(const SystemInputs &inputs, const Intrinsics &camera) {
    return oracle_factory(inputs.options, inputs.pool, inputs.truth)(camera);
}

struct Row {
    SystemDescription description;
    SystemMaker *make;
};

constexpr Row rows[] = {
    {{.name = "paper",
      .title = "This Work (paper)",
      .method = "three-step search, RANSAC pose, forward reprojection"},
     make_daemon_pipeline<Method::paper>},
    {{.name = "lk",
      .title = "LK",
      .method = "the paper's pipeline with pyramidal Lucas-Kanade flow"},
     make_lucas_kanade},
    {{.name = "non-adaptive",
      .title = "Non-Adaptive",
      .method = "linear least squares on all flow, fixed interval (Noraky 2017)",
      .lighting = Lighting::interval},
     make_non_adaptive},
    {{.name = "copy",
      .title = "Copy",
      .method = "dense Farneback flow moves the depth (Wang 2010, causal)",
      .lighting = Lighting::interval},
     make_flow_copy},
    {{.name = "sfm-sift",
      .title = "SfM-SIFT",
      .method = "two-view structure from motion, SIFT keypoints",
      .lighting = Lighting::never,
      .dense = false,
      .fitted_to_truth = true},
     make_sfm_sift},
    {{.name = "sfm-surf",
      .title = "SfM-SURF",
      .method = "two-view structure from motion, SURF keypoints",
      .lighting = Lighting::never,
      .dense = false,
      .fitted_to_truth = true},
     make_sfm_surf},
    {{.name = "sfm-orb",
      .title = "SfM-ORB",
      .method = "two-view structure from motion, ORB keypoints",
      .lighting = Lighting::never,
      .dense = false,
      .fitted_to_truth = true},
     make_sfm_orb},
    {{.name = "opencv-rgbd",
      .title = "OpenCV RGB-D",
      .method = "OpenCV's RGB-D odometry against the last measured map",
      .lighting = Lighting::interval},
     make_rgbd_odometry},
    {{.name = "default",
      .title = "afterglow",
      .method = "alignment with measured keyframes, lit by expected error"},
     make_daemon_pipeline<Method::keyframe>},
    {{.name = "reverse-warp",
      .title = "Reverse Warp",
      .method = "the paper's pipeline, warping in reverse"},
     make_reverse_warp},
    {{.name = "median",
      .title = "Median Filter",
      .method = "the paper's pipeline and a 3x3 median of its maps"},
     make_median_filtered},
    {{.name = "oracle",
      .title = "True-depth pose",
      .method =
          "afterglow with the pose refined on the true depth, lit by the true error and coverage",
      .fitted_to_truth = true},
     make_oracle},
};

constexpr auto descriptions = [] {
    std::array<SystemDescription, std::size(rows)> all;
    std::ranges::transform(rows, all.begin(), &Row::description);
    return all;
}();

} // namespace

std::span<const SystemDescription> systems() {
    return descriptions;
}

const SystemDescription *find_system(std::string_view name) {
    const auto found = std::ranges::find(descriptions, name, &SystemDescription::name);
    return found == descriptions.end() ? nullptr : &*found;
}

std::string title_of(std::string_view name) {
    const SystemDescription *system = find_system(name);
    return std::string(system ? system->title : name);
}

PipelineFactory system_factory(const SystemDescription &system, const SystemInputs &inputs) {
    const Row *row =
        std::ranges::find(rows, system.name, [](const Row &r) { return r.description.name; });
    assert(row != std::end(rows));
    // Once for all: OpenCV's setting is the process's, and must not be made by two threads at a
    // time. Its functions take one thread, since systems run side by side.
    [[maybe_unused]] static const bool set = (cv::setNumThreads(1), true);
    return
        [row, inputs](const RigGeometry &geometry) { return row->make(inputs, geometry.camera()); };
}

} // namespace afterglow
