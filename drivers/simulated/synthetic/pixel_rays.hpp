// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "drivers/simulated/synthetic/surface.hpp"

#include <Eigen/Core>

#include <cmath>

namespace afterglow {

/// The rays of a camera's pixel centres, (X / Z, Y / Z): places in a pinhole camera of focal
/// length 1. Not a number where the lens shows nothing.
class PixelRays {
public:
    explicit PixelRays(const CameraModel &camera);

    int width() const { return x_.width(); }
    int height() const { return x_.height(); }
    bool is_seen(int u, int v) const { return !std::isnan(x_.row(v)[u]); }
    Eigen::Vector2d at(int u, int v) const { return {x_.row(v)[u], y_.row(v)[u]}; }
    /// By how much the ray changes from one column, and from one row, to the next; 0 where no
    /// neighbour is seen.
    Eigen::Matrix2d per_pixel(int u, int v) const;
    /// For shading: the pixel's footprint, log2 of the longer side of it in places.
    float level(int u, int v) const { return level_.row(v)[u]; }
    Places places(int u, int v, int count) const;

private:
    Image<float> x_, y_, level_;
};

} // namespace afterglow
