// SPDX-License-Identifier: Apache-2.0
#include "core/moving/motion_mask.hpp"

#include "core/base/camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <hwy/cache_control.h>

namespace afterglow {
namespace {

constexpr int least_points = 10;
constexpr float outlier_limit = 2.5f; // in deviations of the points that agree
/// A point hidden by something nearer than this share of its depth tells nothing.
constexpr float hidden_share = 0.95f;
/// The mean of a cell's middle (ImagePatch) differs by more than this from what is expected, grey
/// values; multiplied by the keyframe's contrast.
constexpr float unlike_mean = 50;

/// Whether depth differs by less than 10 % between a pixel and four places around it. At a depth
/// edge parallax moves the two sides apart, which changes the mean grey value without motion.
bool has_one_depth(DepthView map, int u, int v) {
    constexpr int around = 12;
    constexpr float alike = 0.1f; // share of the depth
    if (!map.contains(u, v) || map(u, v) == 0)
        return false;
    const auto middle = static_cast<float>(map(u, v));
    for (const int dv : {-around, around})
        for (const int du : {-around, around}) {
            if (!map.contains(u + du, v + dv))
                return false;
            const auto depth = static_cast<float>(map(u + du, v + dv)); // 0 is not alike
            if (!(std::abs(depth - middle) < alike * middle))
                return false;
        }
    return true;
}

/// Whether an image shows more than black in the corners of a square that begins at (u, v) or right
/// behind it. What a camera with a lens does not see is black (LumaResampler).
bool shows_corners(GreyView image, int u, int v) {
    constexpr int side = ImagePatch::side;
    return image(u, v) > 0 && image(u + side, v) > 0 && image(u, v + side) > 0 &&
           image(u + side, v + side) > 0;
}

} // namespace

MotionMask::MotionMask(const Views &views, int image_level, WorkerPool &pool)
    : views_(views), same_(views.publishes_tracking()), image_level_(image_level),
      image_camera_(views.tracking.at_level(image_level)), pool_(pool),
      counts_(pool, Counts(cells(views.published.width), cells(views.published.height))),
      moving_(cells(views.published.width), cells(views.published.height)) {}

Eigen::Vector2i MotionMask::published_pixel(int u, int v, float depth) const {
    if (same_)
        return {u, v};
    const Eigen::Vector3d X =
        views_.published_from_tracking * views_.tracking.back_project(u, v, depth);
    if (!(X.z() > nearest_seen_m))
        return {-1, -1};
    return views_.published.project(X).array().round().cast<int>();
}

void MotionMask::find(const AlignmentTemplate &reference, const Pyramid &image,
                      const Alignment &alignment, DepthView composed) {
    const TemplatePoints &points = reference.points(reference.options().finest_level);
    constexpr int at_once = Residuals::most_points;
    const auto clear = [](Counts &counts) { std::ranges::fill(counts.pixels(), Count{}); };
    counts_.begin();
    pool_.run((points.count + at_once - 1) / at_once, [&](int part, int worker) {
        const int first = part * at_once;
        count(reference, image, alignment, composed, first,
              std::min(first + at_once, points.blocks_end()), counts_.use(worker, clear));
    });
    Counts &all = counts_.use(0, clear);
    counts_.for_each_other([&](const Counts &other) {
        std::ranges::transform(all.pixels(), other.pixels(), all.pixels().begin(), std::plus<>());
    });
    std::ranges::transform(all.pixels(), moving_.pixels().begin(), [](const Count &cell) {
        return cell.points >= least_points && 2 * cell.outliers > cell.points;
    });
}

void MotionMask::count(const AlignmentTemplate &reference, const Pyramid &image,
                       const Alignment &alignment, DepthView composed, int first, int end,
                       Counts &counts) const {
    const int level = reference.options().finest_level;
    const TemplatePoints &points = reference.points(level);
    const auto size = static_cast<std::size_t>(end - first);
    constexpr float all_count = 1e6f; // expected deviations
    const float limit = outlier_limit * alignment.residual_scale;
    PointsSeen seen;
    find_points(points, first, end, image.level(level), reference.camera(level), alignment, seen);
    // Of each point: its pixel of the composed map, null if it is outside, and that pixel's cell.
    std::array<const std::uint16_t *, Residuals::most_points> shown;
    std::array<Count *, Residuals::most_points> cells;
    for (std::size_t i = 0; i < size; ++i) {
        const auto whole = [&](float at) { return static_cast<int>(at) << level; };
        const Eigen::Vector2i at =
            published_pixel(whole(seen.u[i]), whole(seen.v[i]), seen.depth[i]);
        shown[i] = nullptr;
        if (!composed.contains(at.x(), at.y()))
            continue;
        shown[i] = &composed(at.x(), at.y());
        hwy::Prefetch(shown[i]);
        cells[i] = &counts(at.x() / cell_px, at.y() / cell_px);
    }
    Residuals residuals;
    find_residuals(points, first, end, seen.grey.data(), alignment, all_count, residuals);
    for (std::size_t i = 0; i < size; ++i) {
        if (residuals.bin[i] == Residuals::bins || !shown[i])
            continue;
        const auto depth = static_cast<float>(*shown[i]);
        if (depth > 0.0f && depth < hidden_share * 1000.0f * seen.depth[i])
            continue;
        Count &cell = *cells[i];
        ++cell.points;
        const float error = residuals.error[i];
        cell.outliers += error * error * residuals.weight[i] > limit * limit;
    }
}

void MotionMask::add_unlike(const KeyframeImage &then, const Pyramid &now, const Placement &at,
                            DepthView composed) {
    const GreyView grey = now.level(image_level_);
    const Brightness brightness{at.gain, at.offset};
    const Pose tracking_from_published = views_.published_from_tracking.inverse();
    const Pose to_then = at.pose.inverse();
    const Eigen::Vector2d to_middle = Eigen::Vector2d::Constant(0.5 * (ImagePatch::side - 1));
    // Of the cell whose middle is there.
    const auto is_unlike = [&](int u, int v) {
        if (!has_one_depth(composed, u, v))
            return false;
        const Eigen::Vector3d seen =
            tracking_from_published * views_.published.back_project(u, v, 1e-3 * composed(u, v));
        if (!(seen.z() > nearest_seen_m))
            return false;
        const Eigen::Vector2i first =
            (image_camera_.project(seen) - to_middle).array().round().cast<int>();
        const Eigen::Vector2d middle = first.cast<double>() + to_middle;
        const Eigen::Vector3d shown =
            to_then * image_camera_.back_project(middle.x(), middle.y(), seen.z());
        if (!(shown.z() > 0) || !shows_patch(grey, first.cast<float>()))
            return false;
        const Eigen::Vector2f place = (image_camera_.project(shown) - to_middle).cast<float>();
        if (!shows_patch(then.grey, place) || !shows_corners(grey, first.x(), first.y()) ||
            !shows_corners(then.grey, static_cast<int>(place.x()), static_cast<int>(place.y())))
            return false;
        const float excess = mean_excess(grey, first.x(), first.y(), then.grey, place, brightness);
        return std::abs(excess) > unlike_mean * then.contrast;
    };
    pool_.run(moving_.height(), [&](int y) {
        for (int x = 0; x < moving_.width(); ++x)
            if (moving_(x, y) == 0)
                moving_(x, y) = is_unlike(x * cell_px + cell_px / 2, y * cell_px + cell_px / 2);
    });
}

} // namespace afterglow
