// SPDX-License-Identifier: Apache-2.0
#include "core/rig/rig_pipeline.hpp"

#include "core/rig/working_views.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

CameraModel pinhole(const Intrinsics &camera) {
    return {camera, Lens::pinhole, {}};
}

/// A calibrated TOF camera is known to be so much nearer to what it is said to be: by 0.3 % of its
/// focal length, a pixel of its centre and 0.2 degrees.
constexpr float calibrated = 0.1f;

/// Options in pixels are meant for maps as fine as the TOF camera's.
KeyframeOptions adapted(KeyframeOptions options, const RigGeometry &geometry, const Views &views) {
    const double finer = views.surface.fx / geometry.rig.tof.pinhole.fx;
    options.error.edge_registration_px *= static_cast<float>(finer);
    options.surface.smooth_radius_px =
        std::clamp(static_cast<int>(std::lround(options.surface.smooth_radius_px * finer)), 0, 8);
    options.warp.least_edge_distance_px =
        1 + std::clamp(static_cast<int>(
                           std::ceil((options.warp.least_edge_distance_px - 1) * finer - 0.01)),
                       0, far_from_edge - 1);
    options.surface.keep_creases = true;
    options.warp.edges_hide = true;
    options.self_calibration.tilt *= calibrated;
    options.self_calibration.curvature *= calibrated;
    if (views.readout_s > 0)
        options.motion.readout_s = static_cast<float>(views.readout_s);
    return options;
}

} // namespace

RigPipeline::RigPipeline(const KeyframeOptions &options, const RigGeometry &geometry,
                         WorkerPool &pool)
    : RigPipeline(options, geometry, working_views(geometry), pool) {}

RigPipeline::RigPipeline(const KeyframeOptions &options, const RigGeometry &geometry,
                         const Views &views, WorkerPool &pool)
    : pool_(pool), publishes_readings_(geometry.publishes_readings()),
      color_(geometry.rig.color, views.tracking),
      readings_(geometry.rig.tof, geometry.rig.range_along_ray),
      tof_(geometry.rig.tof, pinhole(views.surface)),
      surface_(views.surface.width, views.surface.height), amplitude_(surface_),
      pipeline_(adapted(options, geometry, views), views, pool),
      published_(pinhole(views.published), geometry.published),
      depth_(geometry.published.pinhole.width, geometry.published.pinhole.height),
      confidence_(depth_.width(), depth_.height()) {}

const Estimate &RigPipeline::track(LumaView luma, std::int64_t t_ns) {
    return publish(pipeline_.track(color_.run(luma), t_ns));
}

const Estimate &RigPipeline::measure(const Measurement &measurement) {
    const DepthView z = readings_.run(measurement.depth);
    tof_.run(z, {}, surface_, {}, pool_);
    Measurement seen = surface_;
    seen.lag_s = measurement.lag_s;
    if (!measurement.amplitude.empty()) {
        tof_.nearest(measurement.amplitude, amplitude_);
        seen.amplitude = amplitude_;
    }
    publish(pipeline_.measure(seen));
    if (publishes_readings_)
        lay_over(z);
    return estimate_;
}

/// Readings of the TOF camera replace the resampled depth of their pixels.
void RigPipeline::lay_over(DepthView readings) {
    int added = 0;
    for (int v = 0; v < readings.height(); ++v)
        for (int u = 0; u < readings.width(); ++u)
            if (const std::uint16_t reading = readings(u, v); reading != 0) {
                added += depth_(u, v) == 0;
                depth_(u, v) = reading;
                confidence_(u, v) = measured_confidence;
            }
    estimate_.coverage += percent(added);
}

const Estimate &RigPipeline::publish(const Estimate &composed) {
    const float last_coverage = estimate_.coverage;
    estimate_ = composed;
    if (composed.depth.empty()) {
        estimate_.coverage = last_coverage;
        return estimate_;
    }
    const ImageView<std::uint8_t> confidence =
        composed.confidence.empty() ? ImageView<std::uint8_t>() : confidence_.view();
    const int covered =
        published_.run(composed.depth, composed.confidence, depth_, confidence, pool_);
    estimate_.depth = depth_;
    estimate_.confidence = confidence;
    estimate_.coverage = percent(covered);
    return estimate_;
}

} // namespace afterglow
