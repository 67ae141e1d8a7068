// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/weighted_products.hpp"
#include "core/base/aligned_vector.hpp"
#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/pyramid.hpp"
#include "core/surface/depth_surface.hpp"

#include <span>
#include <vector>

namespace afterglow {

struct TemplateOptions {
    /// Levels used for alignment, finest and coarsest (1 = half size).
    int finest_level = 1;
    int coarsest_level = 4;
    /// Most points kept on a level; the strongest gradients of each cell of the image win.
    int points_per_level = 4000;
    /// Grey values: standard deviation of one pixel's noise in a well-exposed image; it is
    /// multiplied by TemplatePoints::contrast. Weaker gradients are no points, and residuals are
    /// weighted by it.
    float pixel_noise = 2.0f;
    /// Standard deviation of where a gradient g really is: a point's residual is expected to spread
    /// by s with s^2 = (contrast pixel_noise)^2 + (g blur_px)^2.
    float blur_px = 0.15f;
};

/// The textured points of a keyframe on one level of its pyramid, column by column. Columns have
/// whole blocks; what comes after `count` means nothing.
struct TemplatePoints {
    static constexpr int block = WeightedProducts::row_step;
    /// Columns of derivatives of the grey value that a template promises.
    enum Derivative {
        by_motion = 0, ///< 6: (v, w) of the scene, X -> X + v + w x X; per metre and per radian
        by_skew =
            6, ///< 3: Placement::skew, a turn that grows from the first row to the last; per radian
        by_gain = 9, ///< 1: of a gain about a middle grey value, in units of `gain_unit`
        derivatives = 10
    };
    /// So that the column is about as large as the others.
    static constexpr float gain_unit = 0.01f, middle_grey = 128;

    explicit TemplatePoints(int capacity);

    /// Where the last block ends.
    int blocks_end() const { return (count + block - 1) / block * block; }

    int count = 0;
    /// Factor of noise and thresholds in grey values, from 0.15 to 1. 1 on all levels but the
    /// finest; there in proportion to the points' gradients if those are weak, as in a dim image.
    /// Coarse levels are compared while images are displaced and differ by more than noise.
    float contrast = 1;
    AlignedVector<float> x, y, z;   ///< metres, keyframe coordinates
    AlignedVector<float> intensity; ///< grey value in the keyframe
    AlignedVector<float> row;       ///< place in the picture from top (-0.5) to bottom (0.5)
    AlignedVector<float> per_s;     ///< 1 / s of its residuals (TemplateOptions), 1 / grey values
    Image<float> J;                 ///< a row for each Derivative: grey values per unit of it
};

/// Where points were found on a level: pixels, and half the difference of the grey values on both
/// sides, along rows and columns. As long as the columns of the points.
struct FoundPoints {
    AlignedVector<float> u, v, gradient_u, gradient_v;
};

/// All of a keyframe that direct alignment needs, worked out once: points with a strong gradient
/// and a trusted depth, and their Jacobians (inverse-compositional alignment, Baker and Matthews
/// 2004). Allocates when made; build() is real-time safe.
class AlignmentTemplate {
public:
    AlignmentTemplate(const Intrinsics &camera, const TemplateOptions &options);

    void build(const Pyramid &image, const DepthSurface &surface);

    const TemplatePoints &points(int level) const { return levels_[level]; }
    /// TemplatePoints::contrast of the finest level.
    float contrast() const { return levels_[options_.finest_level].contrast; }
    const Intrinsics &camera(int level) const { return cameras_[level]; }
    const TemplateOptions &options() const { return options_; }

private:
    struct Pixel {
        int u, v;
    };
    std::span<const Pixel> steepest_of_cells(GreyView image, int first_row, int cell,
                                             float weakest);
    void find_level(int level, GreyView image, const DepthSurface &surface, float contrast);

    TemplateOptions options_;
    std::vector<Intrinsics> cameras_;
    std::vector<TemplatePoints> levels_;
    std::vector<float> steepness_; ///< of each column of a row of cells, and where
    std::vector<int> steepest_row_;
    std::vector<Pixel> steepest_; ///< of each cell of that row
    FoundPoints found_;           ///< on the level that is built
};

} // namespace afterglow
