// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_surface.hpp"

#include "core/keyframe/surface_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {

/// Weights inverse to the variance of a reading, and of the mean of two, whose deviation is inverse
/// to their amplitude.
struct DepthSurface::AmplitudeWeights {
    ImageView<const std::uint16_t> amplitude;

    float squared(int u, int v) const {
        const float a = std::max(1.0f, static_cast<float>(amplitude(u, v)));
        return a * a;
    }
    float of_reading(int u, int v) const { return 0.5f * squared(u, v); }
    float of_pair(int u, int v, int du, int dv) const {
        const float a = squared(u - du, v - dv), b = squared(u + du, v + dv);
        return 2.0f * a * b / (a + b);
    }
    /// How much noisier a reading is than those around it, 1 to 4: an outlier by the noise of its
    /// brighter neighbours may still be on their surface.
    float excess(int u, int v, int radius) const {
        const float around = 0.25f * (squared(u - radius, v) + squared(u + radius, v) +
                                      squared(u, v - radius) + squared(u, v + radius));
        return std::sqrt(std::clamp(around / squared(u, v), 1.0f, 16.0f));
    }
};

DepthSurface::DepthSurface(const Intrinsics &camera, const SurfaceOptions &options)
    : camera_(camera), options_(options), raw_(camera.width, camera.height),
      smooth_(camera.width, camera.height),
      distance_(camera.width, camera.height, std::uint8_t{far_from_edge}),
      neighbours_(static_cast<std::size_t>(camera.width)), tiles_(camera.width, camera.height) {}

void DepthSurface::build(DepthView depth, WorkerPool &pool, const DepthCorrection &correction,
                         ImageView<const std::uint16_t> amplitude) {
    correction_ = correction;
    load(depth);
    measure_noise();
    find_edges();
    grow_distance();
    const int rows = raw_.height();
    pool.run([&](int worker) {
        const int first = rows * worker / pool.size(), end = rows * (worker + 1) / pool.size();
        if (amplitude.empty())
            smooth(first, end);
        else
            smooth(first, end, AmplitudeWeights{amplitude});
    });
    tiles_.find(smooth_, distance_);
}

void DepthSurface::load(DepthView depth) {
    ReadingRow row;
    row.count = raw_.width();
    row.x0 = static_cast<float>(-camera_.cx / camera_.fx);
    row.dx = static_cast<float>(1 / camera_.fx);
    row.shape = correction_.shape;
    row.nearest_m = options_.nearest_m;
    row.farthest_m = options_.farthest_m;
    int valid = 0;
    for (int v = 0; v < raw_.height(); ++v) {
        row.millimetres = depth.row(v);
        row.y = static_cast<float>((v - camera_.cy) / camera_.fy);
        valid += load_row(row, raw_.row(v));
    }
    fill_ = static_cast<float>(valid) / static_cast<float>(raw_.pixels().size());
}

// White noise of deviation s gives the second difference of three neighbours the deviation s
// sqrt(6), whatever the slope; edges are outliers to the median.
void DepthSurface::measure_noise() {
    constexpr int step = 4, bins_per_sigma = 16, most_sigmas = 16;
    constexpr float median_of_gaussian = 0.6745f;
    std::array<int, bins_per_sigma * most_sigmas + 1> histogram{};
    int count = 0;
    for (int v = step / 2; v < raw_.height(); v += step) {
        const float *z = raw_.row(v);
        for (int u = step / 2; u + 1 < raw_.width(); u += step) {
            if (z[u - 1] == 0.0f || z[u] == 0.0f || z[u + 1] == 0.0f)
                continue;
            const float sigmas = std::abs(z[u - 1] - 2.0f * z[u] + z[u + 1]) /
                                 (2.4495f * median_of_gaussian * options_.noise.sigma(z[u]));
            ++histogram[static_cast<std::size_t>(
                bins_per_sigma * std::min(sigmas, static_cast<float>(most_sigmas)))];
            ++count;
        }
    }
    std::size_t median = 0;
    for (int below = histogram[0]; 2 * below < count; below += histogram[median])
        ++median;
    noise_ = options_.noise.times(std::max(1.0f, static_cast<float>(median) / bins_per_sigma));
}

// A pixel is on an edge when a neighbour is on another surface. A hole is an edge only where both
// of its sides differ: sensor holes inside a surface are common and harmless.
void DepthSurface::find_edges() {
    const int w = raw_.width(), h = raw_.height();
    std::int64_t slope_sum = 0;
    int slopes = 0;
    jump_sum_ = 0;
    jumps_ = 0;
    std::ranges::fill(distance_.pixels(), std::uint8_t{far_from_edge});
    const auto compare_rows = [&](int v, int du, int dv) {
        const int count = w - du;
        const float *row = raw_.row(v);
        const Slopes found =
            compare_neighbours(row, raw_.row(v + dv) + du, count, {options_.edge_relative, noise_},
                               neighbours_.data());
        slope_sum += found.sum;
        slopes += found.pairs;
        const auto end = neighbours_.begin() + count;
        const auto differ = [](Neighbours n) { return n != Neighbours::alike; };
        for (auto at = std::find_if(neighbours_.begin(), end, differ); at != end;
             at = std::find_if(at + 1, end, differ))
            mark(static_cast<int>(at - neighbours_.begin()), v, du, dv);
    };
    for (int v = 0; v < h; ++v) {
        compare_rows(v, 1, 0);
        if (v + 1 < h)
            compare_rows(v, 0, 1);
    }
    // Each pixel has two neighbours to be compared with; a shift in any direction crosses about
    // two thirds of both kinds.
    const float sum = static_cast<float>(std::ldexp(static_cast<double>(slope_sum), -20));
    const float pairs = static_cast<float>(std::max(1, jumps_ + slopes));
    edge_jump_ = jump_sum_ / static_cast<float>(std::max(1, jumps_));
    slope_ = sum / static_cast<float>(std::max(1, slopes));
    variation_ = 1.3f * (jump_sum_ + sum) / pairs;
}

/// Marks an edge between (u, v) and the next reading in the direction (du, dv), if there is one:
/// across a hole of up to four pixels.
void DepthSurface::mark(int u, int v, int du, int dv) {
    const float a = raw_(u, v);
    for (int k = 1; k <= 5; ++k) {
        const int x = u + k * du, y = v + k * dv;
        if (!raw_.view().contains(x, y))
            return;
        const float b = raw_(x, y);
        if (b == 0.0f)
            continue;
        if (std::abs(a - b) >
            edge_step(std::min(a, b)) * (1.0f + 0.5f * static_cast<float>(k - 1))) {
            distance_(u, v) = 1;
            distance_(x, y) = 1;
            // A step can cost a pixel no more than its whole depth.
            jump_sum_ += std::min(std::abs(a - b) / (0.5f * (a + b)), 1.0f);
            ++jumps_;
        }
        return;
    }
}

// The 4-neighbour distance transform: both ways along the rows, then both ways from row to row.
void DepthSurface::grow_distance() {
    const int w = raw_.width(), h = raw_.height();
    for (int v = 0; v < h; ++v) {
        std::uint8_t *d = distance_.row(v);
        for (int u = 1; u < w; ++u)
            d[u] = static_cast<std::uint8_t>(std::min<int>(d[u], d[u - 1] + 1));
        for (int u = w - 2; u >= 0; --u)
            d[u] = static_cast<std::uint8_t>(std::min<int>(d[u], d[u + 1] + 1));
    }
    for (int v = 1; v < h; ++v)
        grow_from_row(distance_.row(v - 1), w, distance_.row(v));
    for (int v = h - 2; v >= 0; --v)
        grow_from_row(distance_.row(v + 1), w, distance_.row(v));
}

// As if all had one amplitude.
void DepthSurface::smooth(int first_row, int end_row) {
    const int w = raw_.width(), h = raw_.height(), r = options_.smooth_radius_px;
    for (int v = first_row; v < end_row; ++v) {
        const float *z = raw_.row(v);
        float *out = smooth_.row(v);
        if (r == 0 || v < r || v >= h - r || w <= 2 * r) {
            std::copy_n(z, w, out);
            continue;
        }
        std::copy_n(z, r, out);
        smooth_row({z + r, raw_.view().stride(), r, w - 2 * r}, noise_, out + r);
        std::copy_n(z + w - r, r, out + w - r);
    }
}

// Weighted mean over the window of what lies on the pixel's own surface: within three sigmas plus a
// slope.
void DepthSurface::smooth(int first_row, int end_row, const AmplitudeWeights &weights) {
    const int w = raw_.width(), h = raw_.height(), r = options_.smooth_radius_px;
    for (int v = first_row; v < end_row; ++v) {
        float *out = smooth_.row(v);
        for (int u = 0; u < w; ++u) {
            const float z = raw_(u, v);
            if (z == 0.0f || r == 0 || u < r || v < r || u >= w - r || v >= h - r) {
                out[u] = z;
                continue;
            }
            const float limit = 3.0f * noise_.sigma(z) * weights.excess(u, v, r);
            float sum = 0.0f;
            float total = 0.0f;
            // Opposite pixels enter as pairs, so that a slope does not shift the mean.
            for (int dv = 0; dv <= r; ++dv) {
                const float *above = raw_.row(v - dv) + u;
                const float *below = raw_.row(v + dv) + u;
                for (int du = dv == 0 ? 1 : -r; du <= r; ++du) {
                    const float a = above[-du], b = below[du];
                    const float mean = 0.5f * (a + b);
                    const bool ok = a != 0.0f && b != 0.0f && std::abs(mean - z) < limit &&
                                    std::abs(a - b) < 2.0f * limit + 0.1f * z;
                    const float weight = weights.of_pair(u, v, du, dv);
                    sum += ok ? weight * mean : 0.0f;
                    total += ok ? weight : 0.0f;
                }
            }
            // The pixel itself counts as half a pair.
            const float own = weights.of_reading(u, v);
            out[u] = (own * z + sum) / (own + total);
        }
    }
}

} // namespace afterglow
