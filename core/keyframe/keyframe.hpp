// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/rigid_motion.hpp"
#include "core/keyframe/alignment_template.hpp"
#include "core/keyframe/depth_surface.hpp"

#include <memory>
#include <vector>

namespace afterglow {

/// A measured depth map, the image that belongs to it, and where the camera was.
struct Keyframe {
    Keyframe(const Intrinsics &camera, const SurfaceOptions &surface_options,
             const TemplateOptions &template_options)
        : surface(camera, surface_options), alignment_template(camera, template_options) {}

    DepthSurface surface;
    AlignmentTemplate alignment_template;
    /// World coordinates (those of the first measured frame) to the camera's, when its image and
    /// when its depth map was exposed.
    Pose from_world;
    Pose depth_from_world;
    Eigen::Vector3d turning = Eigen::Vector3d::Zero(); ///< camera's rotation rate then, rad/s
    std::int64_t t_ns = 0;
};

/// The latest few keyframes, newest first. Allocates when made, and never otherwise: a new one
/// takes the place of the one whose view the others see best.
class KeyframeSet {
public:
    KeyframeSet(int capacity, const Intrinsics &camera, const SurfaceOptions &surface_options,
                const TemplateOptions &template_options);

    int size() const { return size_; }
    Keyframe &operator[](int i) { return *keyframes_[static_cast<std::size_t>(i)]; }
    const Keyframe &operator[](int i) const { return *keyframes_[static_cast<std::size_t>(i)]; }

    /// Makes room and returns the new newest keyframe, to be filled by the caller. `current` is
    /// where the camera is now.
    Keyframe &push(const Pose &current_from_world, const Intrinsics &camera);
    void clear() { size_ = 0; }

private:
    std::vector<std::unique_ptr<Keyframe>> keyframes_;
    int size_ = 0;
};

/// Share of `keyframe`'s surface that a camera at `pose` (keyframe to camera) has in its picture.
float visible_share(const DepthSurface &surface, const Pose &pose, const Intrinsics &camera);

} // namespace afterglow
