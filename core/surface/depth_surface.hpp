// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera.hpp"
#include "core/base/image.hpp"
#include "core/base/worker_pool.hpp"
#include "core/surface/cracks.hpp"
#include "core/surface/depth_correction.hpp"
#include "core/surface/sensor_noise.hpp"
#include "core/surface/surface_kernels.hpp"
#include "core/surface/surface_pieces.hpp"
#include "core/surface/surface_point.hpp"
#include "core/surface/surface_smoothing.hpp"

#include <array>
#include <vector>

namespace afterglow {

struct SurfaceOptions {
    /// Of a map that is not seen to be noisier.
    SensorNoise noise;
    /// Neighbouring pixels whose depths differ by more than this share of the depth, plus three
    /// sigmas of sensor noise, lie on different surfaces.
    float edge_relative = 0.02f;
    /// Readings outside are no readings, metres; none are further than DepthUnits::farthest_m.
    float nearest_m = 0.1f;
    float farthest_m = 12.0f;
    /// Edge-preserving smoothing: half the window, pixels. 0 = none.
    int smooth_radius_px = 2;
    /// Smooth by windows of half that radius where the surface is bent: wide windows round creases
    /// off. For coarse maps, whose pixels are wide.
    bool keep_creases = false;
    /// Widest crack that is filled, pixels: 0 to widest_crack_px.
    int crack_px = widest_crack_px;
};

/// One measured depth map prepared for being carried to other views: smoothed without crossing
/// depth edges, every pixel labelled with its distance from the next depth edge, and cracks filled
/// where a surface is on both sides.
///
/// Allocates when made; the calls are real-time safe.
class DepthSurface {
public:
    DepthSurface(const Intrinsics &camera, const SurfaceOptions &options);

    /// `depth`: readings, millimetres, 0 = none; `correction` makes them true depths. `amplitude`:
    /// of the light that they were made from, to which their noise is inverse; empty: not known.
    void build(DepthView depth, WorkerPool &pool, const DepthCorrection &correction = {},
               ImageView<const std::uint16_t> amplitude = {}) {
        read(depth, pool, correction, amplitude);
        finish();
    }
    /// The two parts of build(). read() gives all that comparing two maps needs; cracks are filled,
    /// and there are pieces, after finish(), which does nothing the second time.
    void read(DepthView depth, WorkerPool &pool, const DepthCorrection &correction = {},
              ImageView<const std::uint16_t> amplitude = {});
    void finish();

    /// Builds the surface anew from `depth`, millimetres, that was rendered from this surface:
    /// correction() is in it already, stays, and is not applied again.
    void rebuild(DepthView depth, WorkerPool &pool);

    /// What the map was built with.
    const DepthCorrection &correction() const { return correction_; }

    /// Metres, 0 = none; in the lowest bits the edge distance (surface_point.hpp).
    ImageView<const float> z() const { return smooth_; }
    /// Pixels to the next depth edge (1 = on it), at most far_from_edge.
    ImageView<const std::uint8_t> edge_distance() const { return distance_; }
    const SurfacePieces &pieces() const { return pieces_; }
    /// Step of a grid over the map, pixels, on which there are readings enough for a mean over the
    /// surface: finer where only few pixels have any, 1 at the finest.
    int sample_step() const { return sample_step_; }
    /// Mean |dz| / z between neighbouring pixels: across depth edges (edge_jump), inside surfaces
    /// (slope).
    float edge_jump() const { return edge_jump_; }
    float slope() const { return slope_; }
    /// Depth step between neighbours that parts two surfaces, metres.
    float edge_step(float z) const { return options_.edge_relative * z + 3.0f * noise_.sigma(z); }
    /// The map's own noise: SurfaceOptions::noise, or more where neighbouring readings differ by
    /// more than that explains. What is common to neighbours does not show.
    const SensorNoise &noise() const { return noise_; }
    /// Part of it that neighbouring readings do not have in common: smoothing takes it away.
    float white_noise() const { return white_noise_; }
    const SurfaceOptions &options() const { return options_; }

private:
    float metres(int units) const { return units_.metres() * static_cast<float>(units); }
    void load(DepthView depth);
    void measure_noise();
    void find_edges();
    void measure_slope();
    void find_sample_step();
    void mark_row(int v);
    void mark(int u, int v, int du, int dv);
    void mark_edge(int u, int v);
    void grow_distance();
    void fill_cracks();

    Intrinsics camera_;
    DepthCorrection correction_;
    SurfaceOptions options_;
    SensorNoise noise_ = options_.noise;
    float white_noise_ = 1; ///< as a share of noise_
    DepthUnits units_;
    Image<UnitDepth> raw_; ///< with rows below the map's that are empty
    SurfaceSmoothing smoothing_;
    Image<float> smooth_;
    Image<std::uint8_t> distance_;
    std::vector<std::int16_t> bend_;                 ///< of columns, ReadingRow::by_column
    std::vector<std::uint8_t> flags_;                ///< of one row, and some that stay 0
    std::array<std::vector<std::int16_t>, 2> steps_; ///< of a row and the next
    Image<std::uint8_t> inside_;                     ///< 1 where a reading is not on an edge
    SurfacePieces pieces_;
    float edge_jump_ = 0, slope_ = 0;
    int sample_step_ = 1;
    float jump_sum_ = 0;
    int jumps_ = 0;
    bool finished_ = true;
};

} // namespace afterglow
