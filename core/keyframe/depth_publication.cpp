// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_publication.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Maps are added until this share of what the last measured frame covered is covered.
constexpr float enough_coverage = 0.98f;
constexpr float least_fill = 0.05f;

/// Mean relative error expected of a map's own pixels.
float fresh_error(const Keyframe &fresh, const Views &views, const KeyframeOptions &options,
                  float error_scale) {
    constexpr int step = 8;
    const DepthSurface &surface = fresh.surface;
    const Intrinsics &camera = views.surface;
    const MapError error =
        map_error(surface, views, views.published_from_surface(),
                  Eigen::Matrix<float, 6, 6>::Zero(), options.error, fresh.calibration_shift);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < camera.height; v += step)
        for (int u = 0; u < camera.width; u += step) {
            const float z = surface.z()(u, v);
            const int distance = surface.edge_distance()(u, v);
            if (z == 0.0f || distance < options.warp.least_edge_distance_px)
                continue;
            sum += pixel_error(error, surface.noise(), options.error.shared_noise, z, distance);
            ++count;
        }
    return count > 0 ? error.misplaced + error_scale * static_cast<float>(sum / count) : 0.0f;
}

/// Share of the pixels that have depth.
float fill(DepthView depth) {
    int filled = 0;
    for (int v = 0; v < depth.height(); ++v)
        filled += depth.width() -
                  static_cast<int>(std::count(depth.row(v), depth.row(v) + depth.width(), 0));
    return static_cast<float>(filled) / static_cast<float>(depth.width() * depth.height());
}

} // namespace

DepthPublication::DepthPublication(const KeyframeOptions &options, const Views &views,
                                   WorkerPool &pool)
    : views_(views), camera_(views.published), options_(options), composer_(views, options, pool),
      motion_mask_(views, options.alignment), local_errors_(views.published) {
    estimate_.depth = composer_.depth();
    estimate_.confidence = composer_.confidence();
}

const Estimate &DepthPublication::nothing(std::int64_t t_ns) {
    t_ns_ = t_ns;
    estimate_.age_frames += ever_measured_;
    estimate_.inliers = estimate_.matches = 0;
    estimate_.wants_measurement = true;
    composer_.clear();
    describe(FrameSource::none, measured_from_world_);
    return estimate_;
}

const Estimate &DepthPublication::estimated(const KeyframeSet &keyframes,
                                            const KeyframeTracker &tracker, const Pose &from_world,
                                            const Twist &while_read,
                                            const DepthCorrection &correction, std::int64_t t_ns) {
    const Alignment &alignment = tracker.alignment();
    if (alignment.good) {
        composer_.compose(keyframes, tracker.reference(), from_world, alignment, while_read,
                          enough_, correction);
        motion_mask_.find(tracker.compared(keyframes), tracker.image(),
                          tracker.compared_alignment(), composer_.depth());
        judge(from_world);
    } else {
        composer_.clear();
    }
    t_ns_ = t_ns;
    ++estimate_.age_frames;
    estimate_.matches = alignment.points;
    estimate_.inliers = static_cast<int>(
        std::lround(alignment.inlier_share * static_cast<float>(alignment.points)));
    estimate_.wants_measurement = !alignment.good;
    describe(alignment.good ? FrameSource::estimated : FrameSource::none, from_world);
    return estimate_;
}

/// Gives the composed map its confidence.
void DepthPublication::judge(const Pose &from_world) {
    local_errors_.predict(composer_.depth(), since_measurement(from_world),
                          static_cast<int>(estimate_.age_frames) + 1);
    composer_.judge({.error_scale = error_scale_.scale(),
                     .mask = &motion_mask_,
                     .moving_error = moving_scale_.scale() * options_.error.moving_error,
                     .local = &local_errors_});
}

const Estimate &DepthPublication::measured(DepthView depth, const Keyframe &fresh,
                                           const Pose &from_world,
                                           const CalibrationState &calibration) {
    if (estimate_.source == FrameSource::estimated)
        learn_errors(depth);
    else
        local_errors_.clear();
    composer_.overlay(depth);
    enough_ = static_cast<int>(enough_coverage * static_cast<float>(composer_.covered()));
    ever_measured_ = true;
    measured_ns_ = t_ns_;
    measured_from_world_ = from_world;
    fresh_fill_ = std::max(fill(depth), least_fill);
    fresh_mre_ = 100 * fresh_error(fresh, views_, options_, error_scale_.scale());
    estimate_.age_frames = 0;
    estimate_.calibration = calibration;
    estimate_.wants_measurement = false;
    describe(FrameSource::measured, from_world);
    return estimate_;
}

/// Compares the map composed for the last image with the one that was measured for it.
void DepthPublication::learn_errors(DepthView depth) {
    const int least_pixels = camera_.width * camera_.height / 400; // 1 % of those compared
    const ImageView<const ComparedErrors> cells = composer_.compare(depth);
    ComparedErrors still, moving;
    for (int y = 0; y < cells.height(); ++y)
        for (int x = 0; x < cells.width(); ++x)
            (motion_mask_.moving()(x, y) != 0 ? moving : still) += cells(x, y);
    local_errors_.learn(cells, error_scale_.scale());
    if (still.pixels >= least_pixels)
        error_scale_.learn(still.true_error(), still.expected_error() / error_scale_.scale());
    if (moving.pixels >= least_pixels)
        moving_scale_.learn(moving.true_error(), options_.error.moving_error);
}

Pose DepthPublication::since_measurement(const Pose &from_world) const {
    return (from_world * measured_from_world_.inverse()).normalized();
}

void DepthPublication::begin_world() {
    ++estimate_.world;
    composer_.clear();
    local_errors_.clear();
}

DepthView DepthPublication::composed() const {
    return composer_.covered() > 0 ? estimate_.depth : DepthView{};
}

/// Fills in what follows from the composed map.
void DepthPublication::describe(FrameSource source, const Pose &from_world) {
    const float covered = static_cast<float>(composer_.covered()) /
                          static_cast<float>(camera_.width * camera_.height);
    estimate_.source = source;
    estimate_.coverage = 100 * covered;
    estimate_.relative_coverage = std::min(100 * covered / fresh_fill_, 100.0f);
    estimate_.expected_mre = composer_.expected_mre();
    estimate_.fresh_mre = fresh_mre_;
    estimate_.pose = since_measurement(from_world);
    estimate_.world_from_camera = from_world.inverse();
    estimate_.tracked = source != FrameSource::none;
    estimate_.age_ns = source == FrameSource::none ? 0 : t_ns_ - measured_ns_;
}

} // namespace afterglow
