// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"

#include <cstdint>

namespace afterglow {

/// Where a published depth map comes from.
enum class FrameSource : std::uint8_t {
    none = 0,      ///< no depth could be given: the map is all zeros
    measured = 1,  ///< by the TOF camera, for this image
    estimated = 2, ///< by warping an earlier measurement to this image
};

/// A depth map for one image, and what is known of it.
struct Estimate {
    FrameSource source = FrameSource::none;
    /// Images since the measurement this map rests on; 0 for a measured map.
    std::uint32_t age_frames = 0;
    std::int64_t age_ns = 0;
    /// Takes points of the last measured map's camera frame to this image's.
    Pose pose{};
    /// Predicted mean relative error, percent. Negative: this preset does not predict it.
    float expected_mre = -1;
    /// The same of a fresh measurement, as far as the last one tells; holds where expected_mre
    /// does.
    float fresh_mre = 0;
    /// Percent of the pixels that have depth.
    float coverage = 0;
    /// Percent of the pixels that a fresh measurement would cover, as far as the last one tells.
    float relative_coverage = 100;
    /// Matches that agree with the pose, of `matches` tried; 0 where no pose was estimated.
    int inliers = 0;
    int matches = 0;
    /// There is no telling what the scene's depth is: only a measurement helps.
    bool wants_measurement = false;
    /// Millimetres; valid until the estimator's next call.
    DepthView depth{};
    /// 0: no depth; 1 to 254: estimated, the higher the better; 255: measured in this frame. Same
    /// size as `depth`.
    ImageView<const std::uint8_t> confidence{};
};

} // namespace afterglow
