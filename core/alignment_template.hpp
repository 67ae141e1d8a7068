// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/camera.hpp"
#include "core/depth_surface.hpp"
#include "core/pyramid.hpp"

#include <Eigen/Core>

#include <vector>

namespace afterglow {

struct TemplateOptions {
    /// Levels used for alignment, finest and coarsest (1 = half size).
    int finest_level = 1;
    int coarsest_level = 4;
    /// Most points kept on a level; the strongest gradients of each cell of the image win.
    int points_per_level = 4000;
    /// Grey levels: standard deviation of one pixel's noise. Weaker gradients carry nothing.
    float pixel_noise = 2.0f;
};

/// One textured point of a keyframe on one level of its pyramid.
struct TemplatePoint {
    float x, y, z;   ///< metres, keyframe coordinates
    float intensity; ///< grey value in the keyframe
    float row;       ///< place in the picture from top (-0.5) to bottom (0.5)
    float gradient;  ///< length of the image gradient, grey values per pixel of the level
    /// Derivative of the grey value by a small motion (v, w) of the scene: X -> X + v + w x X.
    /// Grey values per metre and per radian.
    Eigen::Matrix<float, 6, 1> J;
};

/// All of a keyframe that direct alignment needs, worked out once: points with a strong gradient
/// and a trusted depth, and their Jacobians (inverse-compositional alignment, Baker and Matthews
/// 2004). Allocates when made; build() is real-time safe.
class AlignmentTemplate {
public:
    AlignmentTemplate(const Intrinsics &camera, const TemplateOptions &options);

    void build(const Pyramid &image, const DepthSurface &surface);

    std::span<const TemplatePoint> points(int level) const {
        return std::span(levels_[level]).first(static_cast<std::size_t>(counts_[level]));
    }
    const Intrinsics &camera(int level) const { return cameras_[level]; }
    const TemplateOptions &options() const { return options_; }

private:
    void build_level(int level, ImageView<const float> image, const DepthSurface &surface);

    TemplateOptions options_;
    std::vector<Intrinsics> cameras_;
    std::vector<std::vector<TemplatePoint>> levels_;
    std::vector<int> counts_;
};

} // namespace afterglow
