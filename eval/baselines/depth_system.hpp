// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/estimate.hpp"
#include "core/estimator_options.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace afterglow {

/// A way to give depth for every image from few measurements, or from none: whatever is compared
/// side by side. track() and measure() as Estimator's, but they may allocate. Deterministic: the
/// same calls give the same bits. One thread at a time.
class DepthSystem {
public:
    virtual ~DepthSystem() = default;

    /// Estimates depth for a new image of the camera's size, taken at `t_ns`.
    virtual const Estimate &track(LumaView luma, std::int64_t t_ns) = 0;
    /// Takes depth measured for the image last tracked.
    virtual const Estimate &measure(DepthView depth) = 0;
    /// The true depth of the image to be tracked next. To be called, before each track(), for the
    /// systems that SystemDescription::fitted_to_truth names, and for no other.
    virtual void show_truth(DepthView) {}
};

/// When a system's TOF camera is lit.
enum class Lighting : std::uint8_t {
    adaptive, ///< when the system asks (Estimate::wants_measurement)
    interval, ///< every so many images
    never,    ///< it has none
};

/// A system that can be made here, and what its figures mean.
struct SystemDescription {
    std::string_view name;   ///< for the command line: "lk"
    std::string_view title;  ///< as the paper's tables print it: "LK"
    std::string_view method; ///< what it is, in a few words
    Lighting lighting = Lighting::adaptive;
    /// It gives depth wherever it has measured, not at keypoints alone.
    bool dense = true;
    /// It has no scale of its own: each of its maps is scaled to fit the truth as well as can be.
    bool fitted_to_truth = false;
};

/// All systems, in the order of the paper's tables: "paper" first.
std::span<const SystemDescription> systems();

/// Nothing for a name that systems() does not have. Of `options` each system takes what it is made
/// of (`flow` and `ransac` those made of the paper's pipeline, `keyframe` "default"); `method`
/// follows from the name. `pool` must outlive the system; OpenCV is told to use as many threads.
std::unique_ptr<DepthSystem> make_system(std::string_view name, const Intrinsics &camera,
                                         WorkerPool &pool, const EstimatorOptions &options);

} // namespace afterglow
