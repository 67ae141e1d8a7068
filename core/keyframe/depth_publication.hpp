// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error/error_scale_filter.hpp"
#include "core/error/local_errors.hpp"
#include "core/estimate.hpp"
#include "core/keyframe/depth_composer.hpp"
#include "core/keyframe/keyframe_tracker.hpp"
#include "core/moving/motion_mask.hpp"
#include "core/moving/residual_flow.hpp"

#include <cstdint>
#include <optional>

namespace afterglow {

/// Of two measured maps at the pose to which depth registers them.
struct MapComparison {
    double relative_difference = 0; ///< mean of |difference| / depth
    float displacement = 0;         ///< mean_displacement() from one to the other, radians
};

/// What is published for each image: the composed depth map, its confidences and what follows from
/// them. Allocates when made; the calls are real-time safe.
class DepthPublication {
public:
    DepthPublication(const KeyframeOptions &options, const Views &views, WorkerPool &pool);
    DepthPublication(const DepthPublication &) = delete; // the estimate views the planes
    DepthPublication &operator=(const DepthPublication &) = delete;

    /// A new image, taken at `t_ns`, with no pose to show depth from; asks for a measurement.
    const Estimate &nothing(std::int64_t t_ns);
    /// A new image, taken at `t_ns` and aligned as said. `from_world`: the published camera's pose
    /// for it. It has no map yet; what is said of the map stays as it was.
    const Estimate &tracked(const Alignment &alignment, const Pose &from_world, std::int64_t t_ns);
    /// The image last tracked() with its map: empty, if the alignment is not good. `tracker` has
    /// aligned it; `rate`: CameraMotion::rate().
    const Estimate &estimated(const KeyframeSet &keyframes, const KeyframeTracker &tracker,
                              const Pose &from_world, const Twist &rate,
                              const DepthCorrection &correction);
    /// `depth`, as the published camera sees it from `from_world`, was measured for the last image;
    /// what it lacks stays as estimated. `fresh`: the keyframe made of it; `calibration`: what it
    /// and those before tell of the cameras. `compared`: it and an earlier map.
    const Estimate &measured(DepthView depth, const Keyframe &fresh, const Pose &from_world,
                             const CalibrationState &calibration,
                             const std::optional<MapComparison> &compared);

    /// Whether Estimate::confidence is made; it is at first.
    void want_confidence(bool wanted) { confidence_wanted_ = wanted; }
    int flow_level() const { return flow_.level(); }
    /// Whether there is a map of the last image.
    bool has_map() const { return !estimate_.depth.empty(); }
    /// That map; empty, too, where it has no depth.
    DepthView composed() const;
    /// The map to be measured next is the origin of a new world, where earlier maps have no place.
    /// What was learnt about the sensor stays.
    void begin_world();

private:
    void judge(const Pose &from_world);
    void learn_errors(DepthView depth, const ErrorScales &before);
    /// Motion of the published camera since the last measurement.
    Pose since_measurement(const Pose &from_world) const;
    void describe_image(FrameSource source, const Pose &from_world);
    void describe_map();

    Views views_;
    Intrinsics camera_; ///< the published one
    KeyframeOptions options_;
    DepthComposer composer_;
    MotionMask motion_mask_;
    ResidualFlow flow_;
    LocalErrors local_errors_;
    ErrorScaleFilter error_scales_; ///< of the published maps' expected error
    Estimate estimate_;
    std::int64_t t_ns_ = 0;
    std::int64_t measured_ns_ = 0;
    Pose measured_from_world_; ///< where the published camera was at the last measurement
    bool ever_measured_ = false;
    bool confidence_wanted_ = true;
    float fresh_fill_ = 1;  ///< share of the pixels that the last measured map has
    int enough_ = 0;        ///< pixels covered after which no more maps are added
    float fresh_error_ = 0; ///< mean relative error modelled of the last measured map
    float white_noise_ = 0; ///< mean relative error that its readings do not share
    float misplaced_ = 0;   ///< MapError's, of the same
};

} // namespace afterglow
