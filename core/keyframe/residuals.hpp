// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/keyframe/alignment_template.hpp"

#include <array>

namespace afterglow {

/// Where in an image, and how bright, a template is seen.
struct Placement {
    Pose pose; ///< keyframe coordinates to current ones
    /// Rolling shutter: how much further the camera had turned, against the keyframe, when the last
    /// row was read than when the first was; rotation vector, keyframe coordinates, radians.
    Eigen::Vector3f skew = Eigen::Vector3f::Zero();
    float gain = 1; ///< current grey value = gain * keyframe's + offset
    float offset = 0;
};

/// Some of a template's points in an image of theirs.
struct Residuals {
    std::array<float, TemplatePoints::block> u, v;  ///< place in the image, pixels; 0 if not seen
    std::array<float, TemplatePoints::block> depth; ///< metres
    std::array<float, TemplatePoints::block> error; ///< grey values; 0 if not seen
    std::array<float, TemplatePoints::block> seen; ///< 1 in the picture and before the camera, or 0
};

/// The error is the image's grey value less what the template promises there. Of the block of
/// points that begins with number `first`. `image` and `camera` are those of the
/// points' level. Real-time safe.
void find_residuals(const TemplatePoints &points, int first, ImageView<const float> image,
                    const Intrinsics &camera, const Placement &at, Residuals &residuals);

} // namespace afterglow
