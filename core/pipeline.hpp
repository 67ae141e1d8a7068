// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/estimate.hpp"
#include "core/estimator_options.hpp"
#include "core/rig/rig_geometry.hpp"

#include <cstdint>
#include <functional>
#include <memory>

namespace afterglow {

/// What a TOF camera measured for an image. Its views are read during the call only.
struct Measurement {
    Measurement(DepthView map) : depth(map) {}       // NOLINT(google-explicit-constructor)
    Measurement(const DepthMap &map) : depth(map) {} // NOLINT(google-explicit-constructor)

    DepthView depth;  ///< millimetres, 0 = none; of the TOF camera's size
    double lag_s = 0; ///< how much later than the image it was exposed, as far as is known
    /// Of the depth map's size: the more light came back, the larger; empty: not known.
    ImageView<const std::uint16_t> amplitude{};
};

/// A method that gives depth for every image from few measurements: the paper's, ours, and each
/// baseline of the evaluation.
///
/// track() gets every image, in order of time. When the TOF camera has measured depth for the image
/// last tracked, measure() gets that map, and later images are estimated from it. Neither fails.
/// What a measurement needs only for later images prepare() does, or else the next track().
/// Images and maps have the sizes of the cameras that the pipeline was made for. Deterministic: the
/// same calls give the same bits, whatever the number of workers. The pipelines of core/ are
/// real-time safe: after construction they allocate nothing and take no lock.
/// One thread at a time.
class Pipeline {
public:
    virtual ~Pipeline() = default;

    /// Estimates the depth map of a new image. `t_ns`: its capture time, CLOCK_MONOTONIC.
    virtual const Estimate &track(LumaView luma, std::int64_t t_ns) = 0;
    /// Seconds by which depth maps of images to come are exposed later than the images, as far as
    /// is known; at first 0. What is published along the TOF camera's rays is for that time.
    virtual void expect_lag(double /*lag_s*/) {}
    /// Takes a depth map measured for the image last given to track().
    virtual const Estimate &measure(const Measurement &measurement) = 0;
    /// To be called while there is time before the next image. Changes no estimate.
    virtual void prepare() {}
    /// The cameras have paused: depth from before says nothing about after it and is forgotten.
    /// What was learnt about the cameras stays.
    virtual void restart() = 0;
    /// Whether anybody reads the confidences of the estimates that come; at first somebody does.
    /// Estimate::confidence may be empty while nobody does, to save work; nothing else depends on
    /// it.
    virtual void want_confidence(bool /*wanted*/) {}
    /// Whether anybody reads the depth maps of the images that come; at first somebody does. While
    /// nobody does, track() may estimate the camera's pose alone and leave Estimate::depth empty;
    /// expected errors and coverage are then those of the last map. measure() always gives a map.
    virtual void want_depth(bool /*wanted*/) {}
};

/// Makes a pipeline for these cameras.
using PipelineFactory = std::function<std::unique_ptr<Pipeline>(const RigGeometry &geometry)>;

/// The pipeline that `options.method` names; Method::paper needs registered depth. `pool` must
/// outlive what the factory makes.
PipelineFactory pipeline_factory(const EstimatorOptions &options, WorkerPool &pool);

} // namespace afterglow
