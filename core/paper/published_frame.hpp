// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/estimate.hpp"

#include <cstdint>

namespace afterglow {

/// An Estimate and the memory of its planes, from one image to the next.
///
/// For each image begin(), then one of the give_...(), which fill in what follows from the depth
/// map and the pose: source, age, coverage, confidence, place in the world. Pose, inliers and
/// expected error are the owner's to set. Allocates when made and never otherwise.
class PublishedFrame {
public:
    explicit PublishedFrame(const Intrinsics &camera);
    PublishedFrame(const PublishedFrame &) = delete; // the estimate views the planes
    PublishedFrame &operator=(const PublishedFrame &) = delete;

    /// A new image, taken at `t_ns`. The depth map is still the last image's.
    void begin(std::int64_t t_ns);
    /// `depth` was measured for the image. Same size as the camera's images.
    const Estimate &give_measured(DepthView depth);
    /// depth() now holds the map estimated for the image; its error is not predicted.
    const Estimate &give_estimated();
    /// Nothing can be said about the image; asks for a measurement.
    const Estimate &give_nothing();

    /// The last image had depth, so there is something to go on from.
    bool has_depth() const { return estimate.source != FrameSource::none; }
    DepthMap &depth() { return depth_; }

    Estimate estimate;

private:
    void give(FrameSource source, std::uint8_t confidence);

    DepthMap depth_;
    Image<std::uint8_t> confidence_;
    std::int64_t t_ns_ = 0;
    std::int64_t measured_ns_ = 0;
    std::uint32_t frames_since_measured_ = 0;
    Pose world_from_measured_; ///< of the last measured frame
};

} // namespace afterglow
