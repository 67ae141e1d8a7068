// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/warmup_filter.hpp"
#include "core/base/camera.hpp"
#include "core/estimate.hpp"
#include "drivers/source.hpp"

#include <chrono>
#include <cstdint>
#include <string_view>

namespace afterglow {

/// A map with less than this share of its pixels known, percent, is a sensor that sees nothing:
/// not a measurement.
inline constexpr double min_measured_coverage = 1;

/// Finds the depth map that belongs to an image, by the time at which both were taken.
///
/// Maps of images that have passed, or that were exposed in the dark, are passed over; one whose
/// image is still to come is kept for it. Estimator thread; allocates nothing after it was made,
/// but when a map has not the camera's size.
class DepthPairing {
public:
    /// `camera`: of the depth maps.
    DepthPairing(const Pairing &pairing, const Intrinsics &camera);

    /// The light has gone on: what was read before is of no use.
    void relit();
    /// The map of the image taken at `t_ns`, of which `expected` is the estimate. `none` where it
    /// has not come in the time that an image may wait, or has not settled.
    Capture read(TofSource &tof, Illuminator &light, std::int64_t t_ns, const Estimate &expected);

    /// What read() found; until the next read().
    const DepthMap &depth() const { return map_.depth; }
    /// The amplitude of its light, of the same size; empty where the camera gives none.
    ImageView<const std::uint16_t> amplitude() const { return map_.amplitude; }
    /// When it was taken, on the images' clock.
    std::int64_t t_ns() const { return map_.t_ns; }
    /// The TOF source's count of it.
    std::uint64_t sequence() const { return map_.sequence; }
    /// The sentence behind the last `damaged` or `lost`.
    std::string_view problem() const { return problem_; }

private:
    Capture next(TofSource &tof, std::chrono::steady_clock::time_point deadline);
    void drop_dim();
    Capture examine(const Estimate &expected);
    Capture damaged(std::string_view why);

    const Pairing pairing_;
    const Intrinsics camera_;
    WarmupFilter warmup_;
    DepthFrame map_;
    bool kept_ = false; ///< map_ is of an image to come
    std::string_view problem_;
};

} // namespace afterglow
