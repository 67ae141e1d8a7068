// SPDX-License-Identifier: Apache-2.0
#include "eval/baselines/depth_system.hpp"

#include "core/estimator.hpp"
#include "eval/baselines/makers.hpp"

#include <algorithm>
#include <array>
#include <opencv2/core/utility.hpp>

namespace afterglow {
namespace {

/// The estimator of the daemon, with one of its methods.
template <Method method>
std::unique_ptr<DepthSystem> make_estimator(const EstimatorOptions &options,
                                            const Intrinsics &camera, WorkerPool &pool) {
    EstimatorOptions chosen = options;
    chosen.method = method;
    return std::make_unique<AsDepthSystem<Estimator>>(chosen, camera, pool);
}

struct Row {
    SystemDescription description;
    SystemMaker *make;
};

constexpr Row rows[] = {
    {{.name = "paper",
      .title = "This Work (paper)",
      .method = "three-step search, RANSAC pose, forward reprojection"},
     make_estimator<Method::paper>},
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
     make_estimator<Method::keyframe>},
    {{.name = "reverse-warp",
      .title = "Reverse Warp",
      .method = "the paper's pipeline, warping in reverse"},
     make_reverse_warp},
    {{.name = "median",
      .title = "Median Filter",
      .method = "the paper's pipeline and a 3x3 median of its maps"},
     make_median_filtered},
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

std::unique_ptr<DepthSystem> make_system(std::string_view name, const Intrinsics &camera,
                                         WorkerPool &pool, const EstimatorOptions &options) {
    const Row *row = std::ranges::find(rows, name, [](const Row &r) { return r.description.name; });
    if (row == std::end(rows))
        return nullptr;
    cv::setNumThreads(pool.size());
    return row->make(options, camera, pool);
}

} // namespace afterglow
