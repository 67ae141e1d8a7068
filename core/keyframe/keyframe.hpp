// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/alignment_template.hpp"
#include "core/base/grey.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/views.hpp"
#include "core/moving/residual_flow.hpp"
#include "core/surface/depth_surface.hpp"

#include <memory>
#include <vector>

namespace afterglow {

/// A measured depth map, the image that belongs to it, and where the camera was.
struct Keyframe {
    Keyframe(const Views &views, const SurfaceOptions &surface_options,
             const TemplateOptions &template_options)
        : surface(views.surface, surface_options),
          alignment_template(views.tracking, template_options) {
        const Intrinsics of_grey = views.tracking.at_level(
            ResidualFlow::level_for(views.tracking, template_options.coarsest_level));
        grey = GreyImage(of_grey.width, of_grey.height);
    }

    DepthSurface surface;
    AlignmentTemplate alignment_template;
    GreyImage grey; ///< its image, on the level of ResidualFlow
    /// World coordinates (those of the first measured frame's tracking camera) to the tracking
    /// camera's when its image was exposed, and to the surface camera's when its depth map was.
    Pose from_world;
    Pose depth_from_world;
    Twist rate = Twist::Zero(); ///< CameraMotion::rate() then
    std::int64_t t_ns = 0;
    /// By how much its place in images may be wrong for the rig's calibration, radians, one sigma.
    float calibration_shift = 0;
};

/// The latest few keyframes, newest first. Allocates when made, and never otherwise: a new one
/// takes the place of the one whose view the others see best.
class KeyframeSet {
public:
    KeyframeSet(int capacity, const Views &views, const SurfaceOptions &surface_options,
                const TemplateOptions &template_options);

    int size() const { return size_; }
    Keyframe &operator[](int i) { return *keyframes_[static_cast<std::size_t>(i)]; }
    const Keyframe &operator[](int i) const { return *keyframes_[static_cast<std::size_t>(i)]; }

    /// Makes room and returns the new newest keyframe, to be filled by the caller. `current` is
    /// where the surface camera is now.
    Keyframe &push(const Pose &current_from_world);
    void clear() { size_ = 0; }

private:
    Intrinsics camera_; ///< of surfaces
    std::vector<std::unique_ptr<Keyframe>> keyframes_;
    int size_ = 0;
};

/// Share of a surface of the camera `from` that the camera `to` has in its picture; `pose` takes
/// points from the one's frame to the other's.
float visible_share(const DepthSurface &surface, const Intrinsics &from, const Pose &pose,
                    const Intrinsics &to);

/// Mean angle, radians, between where the camera sees the points of its surface and where it sees
/// them after `pose` has moved them; 1 at most for each point, 0 without points before the camera.
float mean_displacement(const DepthSurface &surface, const Intrinsics &camera, const Pose &pose);

} // namespace afterglow
