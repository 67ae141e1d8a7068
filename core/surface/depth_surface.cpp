// SPDX-License-Identifier: Apache-2.0
#include "core/surface/depth_surface.hpp"

#include "core/base/gaussian.hpp"
#include "core/base/median.hpp"
#include "core/surface/crack_kernels.hpp"
#include "core/surface/cracks.hpp"
#include "core/surface/surface_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace afterglow {
DepthSurface::DepthSurface(const Intrinsics &camera, const SurfaceOptions &options)
    : camera_(camera), options_(options), units_(options.farthest_m),
      // Kernels read past the last row.
      raw_(camera.width, camera.height + 1 + row_slack / std::max(1, camera.width)),
      smoothing_({options.smooth_radius_px, options.keep_creases}, units_, camera.width,
                 camera.height),
      smooth_(camera.width, camera.height),
      distance_(camera.width, camera.height, std::uint8_t{far_from_edge}),
      bend_(static_cast<std::size_t>(camera.width)),
      flags_(static_cast<std::size_t>(camera.width) + sizeof(std::uint64_t)),
      inside_(camera.width, camera.height), pieces_(camera.width, camera.height) {
    for (std::vector<std::int16_t> &steps : steps_)
        steps.resize(static_cast<std::size_t>(camera.width) + 2 * row_slack);
}

void DepthSurface::read(DepthView depth, WorkerPool &pool, const DepthCorrection &correction,
                        ImageView<const std::uint16_t> amplitude) {
    correction_ = correction;
    finished_ = false;
    load(depth);
    measure_noise();
    find_edges();
    grow_distance();
    smoothing_.run({raw_, distance_, amplitude, noise_}, pool, smooth_);
    find_sample_step();
}

void DepthSurface::rebuild(DepthView depth, WorkerPool &pool) {
    const DepthCorrection correction = correction_;
    build(depth, pool);
    correction_ = correction;
}

void DepthSurface::finish() {
    if (std::exchange(finished_, true))
        return;
    if (options_.crack_px > 0)
        fill_cracks();
    pieces_.find(smooth_);
}

/// Holes of the map and readings on an edge become part of the surface that is on two opposite
/// sides of them: most of such edges are noise.
void DepthSurface::fill_cracks() {
    constexpr int reach = widest_crack_px;
    const int w = smooth_.width(), h = smooth_.height(), count = w - 2 * reach;
    const CrackRule rule = {options_.crack_px, {options_.edge_relative, noise_}};
    for (int below = 0; below < h; ++below) {
        find_inside(raw_.row(below), distance_.row(below), w, inside_.row(below));
        if (const int v = below - reach; v >= reach && count > 0)
            fill_cracks_of_row(inside_.row(v) + reach, w, count, rule, smooth_.row(v) + reach);
    }
}

void DepthSurface::load(DepthView depth) {
    const auto units = [&](float metres, auto round) {
        const float reach = std::clamp(metres, 0.0f, DepthUnits::farthest_m);
        return static_cast<UnitDepth>(round(reach * units_.per_metre()));
    };
    const auto share = [](float of_one) {
        return static_cast<std::int16_t>(
            std::lround(std::clamp(32768 * of_one, -32767.0f, 32767.0f)));
    };
    const Eigen::Vector3f &shape = correction_.shape;
    ReadingRow row{};
    row.count = depth.width();
    row.nearest = std::max<UnitDepth>(
        1, units(options_.nearest_m, [](float z) { return std::ceil(z - 0.001f); }));
    row.farthest = units(options_.farthest_m, [](float z) { return std::floor(z + 0.001f); });
    if (!shape.isZero(0)) {
        for (std::size_t u = 0; u < bend_.size(); ++u) {
            const auto x = static_cast<float>((static_cast<double>(u) - camera_.cx) / camera_.fx);
            bend_[u] = share(shape[0] * x + shape[2] * x * x);
        }
        row.by_column = bend_.data();
    }
    for (int v = 0; v < depth.height(); ++v) {
        const auto y = static_cast<float>((v - camera_.cy) / camera_.fy);
        row.millimetres = depth.row(v);
        row.by_row = share(shape[1] * y + shape[2] * y * y);
        load_row(row, units_, raw_.row(v));
    }
}

// White noise of deviation s gives the second difference of three neighbours the deviation s
// sqrt(6), whatever the slope; edges are outliers to the median. Where it is less than that for the
// sensor's sigma, neighbours have the rest of their noise in common.
void DepthSurface::measure_noise() {
    constexpr int step = 4, row_step = 16, bins_per_sigma = 16, most_sigmas = 16;
    std::array<int, bins_per_sigma * most_sigmas + 1> histogram{};
    int count = 0;
    for (int v = row_step / 2; v < smooth_.height(); v += row_step) {
        const UnitDepth *z = raw_.row(v);
        for (int u = step / 2; u + 1 < smooth_.width(); u += step) {
            if (z[u - 1] == 0 || z[u] == 0 || z[u + 1] == 0)
                continue;
            const float sigmas =
                metres(std::abs(z[u - 1] - 2 * z[u] + z[u + 1])) /
                (2.4495f * gaussian::median_absolute * options_.noise.sigma(metres(z[u])));
            ++histogram[static_cast<std::size_t>(
                bins_per_sigma * std::min(sigmas, static_cast<float>(most_sigmas)))];
            ++count;
        }
    }
    const std::size_t median = median_bin(histogram, count);
    const float found = static_cast<float>(median) / bins_per_sigma;
    noise_ = options_.noise.times(std::max(1.0f, found));
    white_noise_ = std::min(1.0f, found);
}

// A pixel is on an edge when a neighbour is on another surface. A hole is an edge only where both
// of its sides differ: sensor holes inside a surface are common and harmless.
void DepthSurface::find_edges() {
    const int w = smooth_.width(), h = smooth_.height();
    jump_sum_ = 0;
    jumps_ = 0;
    std::ranges::fill(distance_.pixels(), std::uint8_t{far_from_edge});
    std::int16_t *steps = steps_[0].data(), *steps_below = steps_[1].data();
    const SixSigmaFactors six_sigmas(noise_, units_);
    find_steps(raw_.row(0), w, options_.edge_relative, six_sigmas, steps);
    for (int v = 0; v < h; ++v) {
        const UnitDepth *row = raw_.row(v), *below = raw_.row(std::min(v + 1, h - 1));
        find_steps(below, w, options_.edge_relative, six_sigmas, steps_below);
        compare_neighbours({row, steps}, {below, steps_below}, w, flags_.data());
        mark_row(v);
        std::swap(steps, steps_below);
    }
    edge_jump_ = jump_sum_ / static_cast<float>(std::max(1, jumps_));
    measure_slope();
}

/// In one row of 32; in all rows, where only few have readings and these were missed.
void DepthSurface::measure_slope() {
    const int w = smooth_.width(), h = smooth_.height();
    const EdgeRule rule = {options_.edge_relative, noise_};
    float sum = 0;
    int pairs = 0;
    for (const int step : {32, 1}) {
        for (int v = 0; v < h; v += step) {
            const UnitDepth *row = raw_.row(v), *below = raw_.row(std::min(v + 1, h - 1));
            const Slopes across = find_slopes(row, row + 1, w - 1, rule, units_);
            const Slopes down = find_slopes(row, below, v + 1 < h ? w : 0, rule, units_);
            sum += across.sum + down.sum;
            pairs += across.pairs + down.pairs;
        }
        if (pairs > 0)
            break;
    }
    slope_ = sum / static_cast<float>(std::max(1, pairs));
}

void DepthSurface::find_sample_step() {
    constexpr int enough = 16;
    for (const int step : {32, 8, 2, 1}) {
        sample_step_ = step;
        int readings = 0;
        for (int v = step / 2; v < smooth_.height(); v += step)
            for (int u = step / 2; u < smooth_.width(); u += step)
                readings += smooth_(u, v) != 0.0f;
        if (readings >= enough)
            return;
    }
}

/// Marks the edges at the pixels of a row that are flagged.
void DepthSurface::mark_row(int v) {
    const int w = smooth_.width();
    for (int first = 0; first < w; first += static_cast<int>(sizeof(std::uint64_t))) {
        std::uint64_t any = 0;
        std::memcpy(&any, &flags_[static_cast<std::size_t>(first)], sizeof any);
        if (any == 0)
            continue;
        const int end = std::min(first + static_cast<int>(sizeof any), w);
        for (int u = first; u < end; ++u) {
            const std::uint8_t flags = flags_[static_cast<std::size_t>(u)];
            if ((flags & parted_from_right) != 0)
                mark(u, v, 1, 0);
            if ((flags & parted_from_below) != 0)
                mark(u, v, 0, 1);
        }
    }
}

/// Marks an edge between (u, v) and the next reading in the direction (du, dv), if there is one:
/// across a hole of up to four pixels.
void DepthSurface::mark(int u, int v, int du, int dv) {
    const UnitDepth here = raw_(u, v);
    for (int k = 1; k <= 5; ++k) {
        const int x = u + k * du, y = v + k * dv;
        if (!distance_.view().contains(x, y))
            return;
        const UnitDepth there = raw_(x, y);
        if (there == 0)
            continue;
        const float a = metres(here), b = metres(there);
        // Neighbours have been compared already.
        if (k == 1 || std::abs(a - b) >
                          edge_step(std::min(a, b)) * (1.0f + 0.5f * static_cast<float>(k - 1))) {
            mark_edge(u, v);
            mark_edge(x, y);
            // A step can cost a pixel no more than its whole depth.
            jump_sum_ += std::min(std::abs(a - b) / (0.5f * (a + b)), 1.0f);
            ++jumps_;
        }
        return;
    }
}

/// The distances from (u, v) along its row.
void DepthSurface::mark_edge(int u, int v) {
    constexpr int reach = far_from_edge - 2;
    // As many as a vector has; the last ones change nothing.
    static constexpr std::array<std::uint8_t, 16> along = {6, 5, 4, 3, 2, 1, 2, 3,
                                                           4, 5, 6, 7, 7, 7, 7, 7};
    std::uint8_t *row = distance_.row(v);
    if (row[u] == 1)
        return;
    const int w = distance_.width(), first = u - reach;
    if (first >= 0 && first + static_cast<int>(along.size()) <= w) {
        std::uint8_t *at = row + first;
        for (std::size_t i = 0; i < along.size(); ++i)
            at[i] = std::min(at[i], along[i]);
        return;
    }
    for (int x = std::max(0, first); x <= std::min(u + reach, w - 1); ++x)
        row[x] = std::min(row[x], along[static_cast<std::size_t>(x - first)]);
}

// The 4-neighbour distance transform: what is marked tells the distance along each row; then both
// ways from row to row.
void DepthSurface::grow_distance() {
    const int w = distance_.width(), h = distance_.height();
    for (int v = 1; v < h; ++v)
        grow_from_row(distance_.row(v - 1), w, distance_.row(v));
    for (int v = h - 2; v >= 0; --v)
        grow_from_row(distance_.row(v + 1), w, distance_.row(v));
}

} // namespace afterglow
