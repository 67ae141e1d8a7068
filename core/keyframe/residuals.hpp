// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/keyframe/alignment_template.hpp"

#include <array>
#include <cstdint>
#include <span>

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
struct PointsSeen {
    using Column = std::array<float, TemplatePoints::block>;

    Column u, v;  ///< place in the image, pixels; 0 if not seen
    Column depth; ///< metres
    Column grey;  ///< grey value there; -1 if the point is not in the picture, or behind the camera
};

/// Looks up the block of points that begins with number `first`. `image` and `camera` are those of
/// the points' level. Real-time safe.
void find_points(const TemplatePoints &points, int first, ImageView<const float> image,
                 const Intrinsics &camera, const Placement &at, PointsSeen &seen);

/// The grey values of a level's points first .. end - 1, whole blocks, as in PointsSeen. `grey`: of
/// all points.
void find_greys(const TemplatePoints &points, int first, int end, ImageView<const float> image,
                const Intrinsics &camera, const Placement &at, std::span<float> grey);

/// How residuals become weights: e / s with s^2 = noise^2 + (g blur)^2, then Geman and McClure's.
struct ResidualScale {
    float pixel_noise = 2; ///< grey values
    float blur_px = 0;
    /// Of Geman and McClure's cost, in expected deviations s. By default so wide that all count.
    float robust_width = 1e6f;
};

/// The residuals of a block of points: grey values seen less what the template promises.
struct Residuals {
    static constexpr int bins = 64;
    static constexpr float bin_width = 0.125f; ///< in expected deviations

    PointsSeen::Column error;  ///< grey values; 0 for points that are not seen
    PointsSeen::Column weight; ///< of the squared error in a normal equation; 0 if not seen
    /// |error| / s in units of `bin_width`, at most bins - 1; `bins` for points that are not seen.
    std::array<std::int32_t, TemplatePoints::block> bin;
};

/// Of the block of points that begins with number `first`; `grey`: their grey values, as from
/// find_greys(). Gain and offset are those of `at`. Real-time safe.
void find_residuals(const TemplatePoints &points, int first, const float *grey, const Placement &at,
                    const ResidualScale &scale, Residuals &residuals);

} // namespace afterglow
