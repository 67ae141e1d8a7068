// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/rig/pixel_places.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// Shows a depth map as another camera at the same place, which looks the same way, would see it:
/// another lens, another size. From one centre nothing hides anything, so it is a matter of
/// interpolation inside surfaces: between four readings of one surface linear, elsewhere the
/// nearest reading. Nothing is put between surfaces, and holes stay.
///
/// The places of all pixels are worked out once. Allocates when made; run() is real-time safe.
class DepthResampler {
public:
    DepthResampler(const CameraModel &from, const CameraModel &to);

    /// Depth along Z, millimetres, 0 = none. `confidence` gets that of the nearest reading; both
    /// confidences may be empty. Returns the number of pixels with depth. Sizes are those of the
    /// two cameras.
    int run(DepthView from, ImageView<const std::uint8_t> from_confidence,
            ImageView<std::uint16_t> to, ImageView<std::uint8_t> to_confidence,
            WorkerPool &pool) const;
    /// Each pixel gets the number of the pixel nearest to it, or 0 outside. Sizes as of run().
    void nearest(ImageView<const std::uint16_t> from, ImageView<std::uint16_t> to) const;

private:
    int from_width_, from_height_, to_width_, to_height_;
    std::vector<Tap> taps_;
};

/// A TOF camera's readings as depth along Z. Allocates when made; run() is real-time safe.
class TofReadings {
public:
    TofReadings(const CameraModel &tof, bool range_along_ray);

    /// Millimetres, 0 = none; valid until the next call.
    DepthView run(DepthView readings);

private:
    std::vector<float> z_of_range_; ///< empty: readings are Z already
    DepthMap z_;
};

} // namespace afterglow
