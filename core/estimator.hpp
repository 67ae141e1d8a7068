// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/estimate.hpp"
#include "core/estimator_options.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"

#include <cstdint>
#include <memory>

namespace afterglow {

/// Depth for every image from few measurements.
///
/// Every image goes through track(), in order of time. When the TOF camera has measured depth for
/// the image last tracked, that goes to measure(), and later images are estimated from it.
/// Deterministic: the same calls with the same options give the same bits, whatever the number of
/// workers. Neither call allocates, locks (but to hand work to the pool) or fails; images must
/// have the camera's size. One thread at a time.
class Estimator {
public:
    Estimator(const EstimatorOptions &options, const Intrinsics &camera, WorkerPool &pool);
    ~Estimator();
    Estimator(Estimator &&) noexcept;

    /// Estimates the depth map of a new image taken at `t_ns` (CLOCK_MONOTONIC).
    const Estimate &track(LumaView luma, std::int64_t t_ns);

    /// Takes a depth map measured for the image last given to track().
    const Estimate &measure(DepthView depth);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace afterglow
