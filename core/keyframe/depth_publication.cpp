// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_publication.hpp"

#include "core/base/gaussian.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Maps are added until this share of what the last measured frame covered is covered.
constexpr float enough_coverage = 0.98f;
constexpr float least_fill = 0.05f;

/// Measured maps that are registered to each other were taken many images apart. They differ by
/// more than their displacement explains, and count by this factor: docs/estimation.md, section 7.
constexpr double registered_share = 0.87;

/// What is left of an error without a part of it that is added in quadrature.
double left_of(double error, double part) {
    return std::sqrt(std::max(error * error - part * part, 0.0));
}

/// Mean relative errors of a map just measured.
struct FreshErrors {
    float modelled = 0;
    float white = 0; ///< that neighbouring readings do not share
};
FreshErrors fresh_errors(const DepthSurface &surface, const MapError &error,
                         const Intrinsics &camera, const KeyframeOptions &options) {
    constexpr int step = 16; // pixels
    const SensorNoise noise = surface.noise();
    float modelled = 0, white = 0;
    int count = 0;
    for (int v = 0; v < camera.height; v += step)
        for (int u = 0; u < camera.width; u += step) {
            const float z = surface.z()(u, v);
            const int distance = surface.edge_distance()(u, v);
            if (z == 0.0f || distance < options.warp.least_edge_distance_px)
                continue;
            modelled +=
                pixel_error(error, noise, options.error.shared_noise, z, distance).scaled({});
            white += gaussian::mean_absolute * surface.white_noise() * noise.sigma(z) / z;
            ++count;
        }
    const auto pixels = static_cast<float>(std::max(count, 1));
    return {modelled / pixels, white / pixels};
}

} // namespace

DepthPublication::DepthPublication(const KeyframeOptions &options, const Views &views,
                                   WorkerPool &pool)
    : views_(views), camera_(views.published), options_(options), composer_(views, options, pool),
      motion_mask_(
          views, ResidualFlow::level_for(views.tracking, options.alignment_template.coarsest_level),
          pool),
      flow_(views, options.alignment_template.coarsest_level, options.compose.follow_moving),
      local_errors_(views.published) {
    estimate_.depth = composer_.depth();
}

const Estimate &DepthPublication::nothing(std::int64_t t_ns) {
    t_ns_ = t_ns;
    estimate_.age_frames += ever_measured_;
    estimate_.inliers = estimate_.matches = 0;
    estimate_.wants_measurement = true;
    composer_.clear();
    describe_image(FrameSource::none, measured_from_world_);
    describe_map();
    return estimate_;
}

const Estimate &DepthPublication::tracked(const Alignment &alignment, const Pose &from_world,
                                          std::int64_t t_ns) {
    t_ns_ = t_ns;
    ++estimate_.age_frames;
    estimate_.matches = alignment.points;
    estimate_.inliers = static_cast<int>(
        std::lround(alignment.inlier_share * static_cast<float>(alignment.points)));
    estimate_.wants_measurement = !alignment.good;
    estimate_.depth = {};
    estimate_.confidence = {};
    describe_image(alignment.good ? FrameSource::estimated : FrameSource::none, from_world);
    return estimate_;
}

const Estimate &DepthPublication::estimated(const KeyframeSet &keyframes,
                                            const KeyframeTracker &tracker, const Pose &from_world,
                                            const Twist &rate, const DepthCorrection &correction) {
    const Alignment &alignment = tracker.alignment();
    if (alignment.good) {
        composer_.compose(keyframes, tracker.reference(), from_world, alignment, rate, enough_,
                          correction);
        motion_mask_.find(tracker.compared(keyframes), tracker.image(),
                          tracker.compared_alignment(), composer_.drawn());
        const Keyframe &reference = keyframes[tracker.reference()];
        const KeyframeImage then = {reference.grey, reference.t_ns,
                                    reference.alignment_template.contrast()};
        if (!tracker.bridged())
            motion_mask_.add_unlike(then, tracker.image(), alignment, composer_.drawn());
        flow_.find(then, tracker.image(), alignment, composer_.drawn(), motion_mask_.moving());
        composer_.displace(flow_);
        judge(from_world);
    } else {
        composer_.clear();
    }
    describe_map();
    return estimate_;
}

/// Gives the composed map its confidence.
void DepthPublication::judge(const Pose &from_world) {
    local_errors_.predict(composer_.depth(), since_measurement(from_world),
                          static_cast<int>(estimate_.age_frames));
    composer_.judge({.scales = error_scales_.scales(), .local = &local_errors_},
                    confidence_wanted_);
}

const Estimate &DepthPublication::measured(DepthView depth, const Keyframe &fresh,
                                           const Pose &from_world,
                                           const CalibrationState &calibration,
                                           const std::optional<MapComparison> &compared) {
    const ErrorScales before = error_scales_.scales();
    if (compared)
        // Surfaces are smoothed; the readings that estimates are compared with are not.
        error_scales_.learn_fresh(
            std::hypot(registered_share * compared->relative_difference, white_noise_),
            uncorrelated_share(compared->displacement) * fresh_error_);
    composer_.judge_rest();
    if (estimate_.source == FrameSource::estimated)
        learn_errors(depth, before);
    else
        local_errors_.clear();
    const auto measured_pixels = static_cast<float>(composer_.overlay(depth));
    enough_ = static_cast<int>(enough_coverage * static_cast<float>(composer_.covered()));
    ever_measured_ = true;
    measured_ns_ = t_ns_;
    measured_from_world_ = from_world;
    fresh_fill_ =
        std::max(measured_pixels / static_cast<float>(camera_.width * camera_.height), least_fill);
    const MapError error =
        fresh_map_error(fresh.surface, views_.surface, options_.error, fresh.calibration_shift);
    const FreshErrors errors = fresh_errors(fresh.surface, error, views_.surface, options_);
    fresh_error_ = errors.modelled;
    white_noise_ = errors.white;
    misplaced_ = error.misplaced;
    estimate_.age_frames = 0;
    estimate_.calibration = calibration;
    estimate_.wants_measurement = false;
    describe_image(FrameSource::measured, from_world);
    describe_map();
    return estimate_;
}

/// Compares the map composed for the last image with the one that was measured for it. `before`:
/// the scales that the composed map's confidences have. The scales are learnt from quiet cells
/// alone, whose error comes from the camera's motion and not from things that move.
void DepthPublication::learn_errors(DepthView depth, const ErrorScales &before) {
    const int least_pixels = camera_.width * camera_.height / 400; // 1 % of those compared
    const ImageView<const ComparedErrors> cells = composer_.compare(depth);
    ComparedErrors quiet;
    for (int y = 0; y < cells.height(); ++y)
        for (int x = 0; x < cells.width(); ++x) {
            const ComparedErrors &cell = cells(x, y);
            const double local = local_errors_.expected()(x, y) * cell.pixels;
            if (motion_mask_.moving()(x, y) == 0 && 2 * local <= cell.expected_sum) {
                quiet += cell;
                quiet.expected_sum -= local;
            }
        }
    double ratio = 1;
    if (quiet.pixels >= least_pixels) {
        const double truth = quiet.true_error(), expected = quiet.expected_error();
        ratio = truth / expected;
        const float fresh = composer_.uncorrelated() * fresh_error_;
        error_scales_.learn_carried(truth, fresh,
                                    left_of(expected, before.fresh * fresh) / before.carried);
    }
    local_errors_.learn(cells, ratio);
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

/// Says where the last image was taken, and what its map comes from.
void DepthPublication::describe_image(FrameSource source, const Pose &from_world) {
    estimate_.source = source;
    estimate_.pose = since_measurement(from_world);
    estimate_.world_from_camera = from_world.inverse();
    estimate_.tracked = source != FrameSource::none;
    estimate_.age_ns = source == FrameSource::none ? 0 : t_ns_ - measured_ns_;
}

/// Fills in what follows from the composed map.
void DepthPublication::describe_map() {
    const auto all = static_cast<float>(camera_.width * camera_.height);
    const auto left_empty = static_cast<float>(composer_.left_empty());
    const auto covered = static_cast<float>(composer_.covered());
    estimate_.depth = composer_.depth();
    if (confidence_wanted_ || estimate_.source == FrameSource::measured)
        estimate_.confidence = composer_.confidence();
    else
        estimate_.confidence = {};
    estimate_.coverage = 100 * covered / all;
    estimate_.relative_coverage = std::min(estimate_.coverage / fresh_fill_, 100.0f);
    estimate_.expected_mre = composer_.expected_mre();
    estimate_.moved_mre =
        100 * options_.error.moving_error * left_empty / std::max(covered + left_empty, 1.0f);
    estimate_.independent_mre = composer_.independent_mre();
    estimate_.fresh_mre = 100 * (misplaced_ + error_scales_.scales().fresh * fresh_error_);
}

} // namespace afterglow
