// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/surface/sensor_noise.hpp"
#include "core/surface/unit_depth.hpp"

#include <cstdint>
#include <vector>

namespace afterglow {

/// A measured map before it is smoothed.
struct UnsmoothedMap {
    /// Readings, 0 = none. There are rows below the map's, since kernels read past its last one.
    ImageView<const UnitDepth> z;
    /// Pixels to the next depth edge. The other images have its size.
    ImageView<const std::uint8_t> edge_distance;
    /// Of the light that readings were made from; empty: not known.
    ImageView<const std::uint16_t> amplitude;
    SensorNoise noise;
};

struct SmoothingOptions {
    int radius_px = 2;         ///< SurfaceOptions::smooth_radius_px
    bool keep_creases = false; ///< SurfaceOptions::keep_creases
};

/// Smooths measured maps without crossing depth edges: each reading becomes the mean of what lies
/// on its own surface in a window around it.
///
/// Allocates when made; run() is real-time safe.
class SurfaceSmoothing {
public:
    SurfaceSmoothing(const SmoothingOptions &options, const DepthUnits &units, int width,
                     int height);

    /// `smooth`: points as with_edge_distance() makes them, metres, 0 = none.
    void run(const UnsmoothedMap &map, WorkerPool &pool, ImageView<float> smooth);

private:
    class NarrowWindows;
    float metres(int units) const { return units_.metres() * static_cast<float>(units); }
    void add_edge_distances(const UnsmoothedMap &map, int v, float *points) const;
    void smooth_in_passes(const UnsmoothedMap &map, WorkerPool &pool, ImageView<float> smooth);
    void smooth_line(const UnsmoothedMap &map, int v, int radius, float *out) const;
    void keep_creases(const UnsmoothedMap &map, ImageView<float> smooth);

    SmoothingOptions options_;
    DepthUnits units_;
    Image<std::uint16_t>
        across_;              ///< smoothed along its rows; empty: maps are not smoothed in passes
    Image<UnitDepth> limits_; ///< of the means of opposite readings; 0 where a row has none
    Image<float> narrow_;     ///< NarrowWindows' differences: of a few rows, metres
    std::vector<float> sums_; ///< of narrow_'s columns
};

} // namespace afterglow
