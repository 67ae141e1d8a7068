// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/alignment_template.hpp"
#include "core/base/grey.hpp"
#include "core/base/rigid_motion.hpp"

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

/// The residuals of some blocks of points: grey values seen less what the template promises. A
/// point of which more than white is promised, and white is seen, counts as not seen: it tells
/// nothing.
struct Residuals {
    static constexpr int bins = 64;
    static constexpr float bin_width = 0.125f; ///< in expected deviations

    static constexpr int most_points = 8 * TemplatePoints::block;
    using Column = std::array<float, most_points>;

    alignas(cache_line) Column error;  ///< grey values; 0 for points that are not seen
    alignas(cache_line) Column weight; ///< of the squared error in a normal equation; 0 if not seen
    /// |error| / s in units of `bin_width`, at most bins - 1; `bins` for points that are not seen.
    alignas(cache_line) std::array<std::int32_t, most_points> bin;
};

/// Some of a template's points in an image of theirs.
struct PointsSeen {
    using Column = std::array<float, Residuals::most_points>;

    Column u, v;  ///< place in the image, pixels; 0 if not seen
    Column depth; ///< metres
    /// Grey value there; -1 if the point is not in the picture, is behind the camera or is none.
    Column grey;
};

/// Looks up a level's points first .. end - 1, whole blocks. `image` and `camera` are those of the
/// level. Real-time safe.
void find_points(const TemplatePoints &points, int first, int end, GreyView image,
                 const Intrinsics &camera, const Placement &at, PointsSeen &seen);

/// The grey values of a level's points first .. end - 1, whole blocks, as in PointsSeen. `grey`: of
/// all points.
void find_greys(const TemplatePoints &points, int first, int end, GreyView image,
                const Intrinsics &camera, const Placement &at, std::span<float> grey);

/// Of a level's points first .. end - 1, whole blocks; `grey`: their grey values, as from
/// find_greys(). Gain and offset are those of `at`; `robust_width`: of Geman and McClure's cost, in
/// expected deviations s. Real-time safe.
void find_residuals(const TemplatePoints &points, int first, int end, const float *grey,
                    const Placement &at, float robust_width, Residuals &residuals);

} // namespace afterglow
