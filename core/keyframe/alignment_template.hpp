// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/pyramid.hpp"
#include "core/keyframe/depth_surface.hpp"

#include <Eigen/Core>

#include <vector>

namespace afterglow {

struct TemplateOptions {
    /// Levels used for alignment, finest and coarsest (1 = half size).
    int finest_level = 1;
    int coarsest_level = 4;
    /// Most points kept on a level; the strongest gradients of each cell of the image win.
    int points_per_level = 4000;
    /// Grey values: standard deviation of one pixel's noise. Weaker gradients are no points, and
    /// residuals are weighted by it.
    float pixel_noise = 2.0f;
};

/// The textured points of a keyframe on one level of its pyramid, column by column. Columns have
/// whole blocks; what comes after `count` means nothing.
struct TemplatePoints {
    static constexpr int block = 64;

    explicit TemplatePoints(int capacity);

    int count = 0;
    std::vector<float> x, y, z;   ///< metres, keyframe coordinates
    std::vector<float> intensity; ///< grey value in the keyframe
    std::vector<float> row;       ///< place in the picture from top (-0.5) to bottom (0.5)
    std::vector<float> gradient;  ///< length of the image gradient, grey values per level's pixel
    /// Derivative of the grey value by a small motion (v, w) of the scene: X -> X + v + w x X.
    /// Grey values per metre and per radian.
    Eigen::Matrix<float, Eigen::Dynamic, 6> J;
};

/// All of a keyframe that direct alignment needs, worked out once: points with a strong gradient
/// and a trusted depth, and their Jacobians (inverse-compositional alignment, Baker and Matthews
/// 2004). Allocates when made; build() is real-time safe.
class AlignmentTemplate {
public:
    AlignmentTemplate(const Intrinsics &camera, const TemplateOptions &options);

    void build(const Pyramid &image, const DepthSurface &surface);

    const TemplatePoints &points(int level) const { return levels_[level]; }
    const Intrinsics &camera(int level) const { return cameras_[level]; }
    const TemplateOptions &options() const { return options_; }

private:
    void build_level(int level, ImageView<const float> image, const DepthSurface &surface);

    TemplateOptions options_;
    std::vector<Intrinsics> cameras_;
    std::vector<TemplatePoints> levels_;
};

} // namespace afterglow
