// SPDX-License-Identifier: Apache-2.0
#include "core/motion_mask.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr int least_points = 10;
constexpr float outlier_limit = 2.5f; // in deviations of the points that agree
/// A point hidden by something nearer than this share of its depth tells nothing.
constexpr float hidden_share = 0.95f;

} // namespace

MotionMask::MotionMask(const Intrinsics &camera, const AlignmentOptions &options)
    : options_(options),
      counts_((camera.width + cell_px - 1) / cell_px, (camera.height + cell_px - 1) / cell_px),
      moving_(counts_.width(), counts_.height()) {}

void MotionMask::find(const AlignmentTemplate &reference, const Pyramid &image,
                      const Alignment &alignment, DepthView composed) {
    std::fill(counts_.pixels().begin(), counts_.pixels().end(), Count{});
    const int level = reference.options().finest_level;
    const ImageView<const float> grey = image.level(level);
    const Intrinsics &camera = reference.camera(level);
    const float noise2 = options_.pixel_noise * options_.pixel_noise;
    const float blur2 = options_.blur_px * options_.blur_px;
    const float limit = outlier_limit * std::max(alignment.residual_scale, 1.0f);
    for (const TemplatePoint &p : reference.points(level)) {
        const Eigen::Vector3d at{p.x, p.y, p.z};
        const Eigen::Vector3d turn = alignment.skew.cast<double>() * static_cast<double>(p.row);
        const Eigen::Vector3d X = alignment.pose * (at + turn.cross(at));
        if (!(X.z() > 0.05))
            continue;
        const Eigen::Vector2d at_px = camera.project(X);
        if (!(at_px.x() >= 0 && at_px.y() >= 0 && at_px.x() < grey.width() - 1.01 &&
              at_px.y() < grey.height() - 1.01))
            continue;
        const int u = static_cast<int>(at_px.x()), v = static_cast<int>(at_px.y());
        const int full_u = u << level, full_v = v << level;
        const auto shown = static_cast<float>(composed(full_u, full_v));
        if (shown > 0.0f && shown < hidden_share * 1000.0f * static_cast<float>(X.z()))
            continue;
        const auto fu = static_cast<float>(at_px.x() - u), fv = static_cast<float>(at_px.y() - v);
        const float *top = grey.row(v) + u;
        const float *bottom = grey.row(v + 1) + u;
        const float upper = top[0] + fu * (top[1] - top[0]);
        const float lower = bottom[0] + fu * (bottom[1] - bottom[0]);
        const float e =
            upper + fv * (lower - upper) - alignment.gain * p.intensity - alignment.offset;
        const float deviation = std::sqrt(noise2 + blur2 * p.gradient * p.gradient);
        Count &cell = counts_(full_u / cell_px, full_v / cell_px);
        ++cell.points;
        cell.outliers += std::abs(e) > limit * deviation;
    }
    for (std::size_t i = 0; i < counts_.pixels().size(); ++i) {
        const Count cell = counts_.pixels()[i];
        moving_.pixels()[i] = cell.points >= least_points && 2 * cell.outliers > cell.points;
    }
}

} // namespace afterglow
