// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/weighted_products.hpp"
#include "core/base/camera.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/surface/depth_surface.hpp"

#include <array>

namespace afterglow {

/// Points of a measured surface that are compared with another map: a block of columns, of which
/// the first `count` mean something; the rest are finite.
struct ComparedPoints {
    static constexpr int block = WeightedProducts::row_step;
    using Column = std::array<float, block>;

    int count = 0;
    alignas(16) Column x{}, y{}; ///< X / Z and Y / Z
    alignas(16) Column z{};      ///< metres
};

/// The depths of such points, carried along a pose, beside those of the other map.
struct DepthComparisons {
    using Column = ComparedPoints::Column;
    /// Columns of derivatives of the error: by the motion (v, w) applied after the pose, X -> X + v
    /// + w x X (6), and by the shape that both maps have in common (3).
    static constexpr int motions = 6, shapes = 3;

    alignas(16) std::array<Column, motions + shapes> J;
    /// Metres: the map's depth less the point's.
    alignas(16) Column error;
    /// 1 / sigma^2 times Geman and McClure's weight; 0 for points that the map does not show inside
    /// of a surface.
    alignas(16) Column weight;
    /// |error| / sigma in units of `bin_width`, at most bins - 1; `bins` for points not shown.
    alignas(16) std::array<int, ComparedPoints::block> bin;

    static constexpr int bins = 64;
    static constexpr float bin_width = 0.25f;
};

/// What is asked of a comparison beside the errors.
struct ComparisonOptions {
    /// Square of Geman and McClure's width, in sigmas.
    float robust_width2;
    /// The shape's derivatives are found, too, and errors are as if both maps had been taken as
    /// they came, without their correction.
    bool with_shape = false;
    /// Of the map that the points are from.
    Eigen::Vector3f from_shape = Eigen::Vector3f::Zero();
};

/// Compares points, seen from their own map, with the map `to` at `pose`, which takes points of the
/// one's frame to the other's. Columns after the points' count are given no weight.
/// Real-time safe.
void compare_points(const ComparedPoints &points, const DepthSurface &to, const Intrinsics &camera,
                    const Pose &pose, const ComparisonOptions &options, DepthComparisons &out);

/// Adds a block's products: of the first `columns` of J, and of the error, which follows them.
/// Real-time safe.
void add_products(const DepthComparisons &block, int columns, WeightedProducts &products);

} // namespace afterglow
