// SPDX-License-Identifier: Apache-2.0
#include "core/surface/surface_smoothing.hpp"

#include "core/base/gaussian.hpp"
#include "core/base/median.hpp"
#include "core/surface/smoothing_kernels.hpp"
#include "core/surface/surface_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

/// Windows of this radius, pixels, are smoothed in two passes.
constexpr int radius_of_passes = 2;

/// Weights inverse to the variance of a reading, and of the mean of two, whose deviation is inverse
/// to their amplitude.
struct AmplitudeWeights {
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

} // namespace

SurfaceSmoothing::SurfaceSmoothing(const SmoothingOptions &options, const DepthUnits &units,
                                   int width, int height)
    : options_(options), units_(units) {
    if (options.radius_px == radius_of_passes && !options.keep_creases &&
        width >= 2 * radius_of_passes + least_of_pass) {
        across_ = Image<std::uint16_t>(width, height);
        limits_ = Image<UnitDepth>(width, height);
    }
    if (options.keep_creases) {
        narrow_ = Image<float>(width, 2 * options.radius_px + 1);
        sums_.resize(static_cast<std::size_t>(width));
    }
}

void SurfaceSmoothing::run(const UnsmoothedMap &map, WorkerPool &pool, ImageView<float> smooth) {
    if (!across_.empty() && map.amplitude.empty()) {
        smooth_in_passes(map, pool, smooth);
        return;
    }
    pool.run_strips(smooth.height(), [&](int first, int end) {
        for (int v = first; v < end; ++v)
            smooth_line(map, v, options_.radius_px, smooth.row(v));
    });
    if (options_.keep_creases && options_.radius_px > 1)
        keep_creases(map, smooth);
    for (int v = 0; v < smooth.height(); ++v)
        add_edge_distances(map, v, smooth.row(v));
}

void SurfaceSmoothing::add_edge_distances(const UnsmoothedMap &map, int v, float *points) const {
    const std::uint8_t *const distance = map.edge_distance.row(v);
    const int count = map.edge_distance.width();
    for (int u = 0; u < count; ++u) // the compiler makes vector code of it
        points[u] = with_edge_distance(points[u], distance[u]);
}

/// Along rows, then along columns.
void SurfaceSmoothing::smooth_in_passes(const UnsmoothedMap &map, WorkerPool &pool,
                                        ImageView<float> smooth) {
    const int w = smooth.width(), h = smooth.height();
    const SixSigmaFactors six_sigmas(map.noise, units_);
    const auto inner = [&](int v) { return v >= radius_of_passes && v < h - radius_of_passes; };
    pool.run_strips(h, [&](int first, int end) {
        for (int v = first; v < end; ++v) {
            const UnitDepth *const z = map.z.row(v);
            std::uint16_t *const across = across_.row(v);
            const auto copy = [&](int begin, int count) {
                std::transform(z + begin, z + begin + count, across + begin, [](UnitDepth depth) {
                    return static_cast<std::uint16_t>(depth - 1);
                });
            };
            if (!inner(v)) {
                copy(0, w);
                continue;
            }
            copy(0, radius_of_passes);
            copy(w - radius_of_passes, radius_of_passes);
            smooth_row_across(z + radius_of_passes, w - 2 * radius_of_passes, six_sigmas,
                              across + radius_of_passes, limits_.row(v) + radius_of_passes);
        }
    });
    pool.run_strips(h, [&](int first, int end) {
        for (int v = first; v < end; ++v) {
            float *const out = smooth.row(v);
            if (inner(v)) {
                smooth_row_down({across_.row(v), across_.width(), limits_.row(v)}, w, units_,
                                map.edge_distance.row(v), out);
                continue;
            }
            const UnitDepth *const z = map.z.row(v);
            std::transform(z, z + w, out, [&](UnitDepth depth) { return metres(depth); });
            add_edge_distances(map, v, out);
        }
    });
}

// Mean over the window of what lies on the pixel's own surface: within three sigmas plus a slope.
void SurfaceSmoothing::smooth_line(const UnsmoothedMap &map, int v, int radius, float *out) const {
    const int w = map.edge_distance.width(), h = map.edge_distance.height(), r = radius;
    const UnitDepth *row = map.z.row(v);
    const bool whole = r > 0 && v >= r && v < h - r && w > 2 * r;
    const int margin = whole ? r : w;
    for (int u = 0; u < margin; ++u)
        out[u] = metres(row[u]);
    if (!whole)
        return;
    for (int u = w - r; u < w; ++u)
        out[u] = metres(row[u]);
    if (map.amplitude.empty()) { // as if all had one amplitude
        smooth_row({row + r, map.z.stride(), r, w - 2 * r}, SixSigmaFactors(map.noise, units_),
                   units_, out + r);
        return;
    }
    const AmplitudeWeights weights = {map.amplitude};
    for (int u = r; u < w - r; ++u) {
        const float z = metres(row[u]);
        if (z == 0.0f) {
            out[u] = z;
            continue;
        }
        const float limit = 3.0f * map.noise.sigma(z) * weights.excess(u, v, r);
        float sum = 0.0f;
        float total = 0.0f;
        // Opposite pixels enter as pairs, so that a slope does not shift the mean.
        for (int dv = 0; dv <= r; ++dv) {
            const UnitDepth *above = map.z.row(v - dv) + u;
            const UnitDepth *below = map.z.row(v + dv) + u;
            for (int du = dv == 0 ? 1 : -r; du <= r; ++du) {
                const float a = metres(above[-du]), b = metres(below[du]);
                const float mean = 0.5f * (a + b);
                const bool ok = a != 0.0f && b != 0.0f && std::abs(mean - z) < limit;
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

/// The difference between a map smoothed by narrow windows, of half the radius, and smoothed by
/// wide ones, and its mean over a wide window. Row by row: few rows are kept. Metres.
class SurfaceSmoothing::NarrowWindows {
public:
    NarrowWindows(SurfaceSmoothing &of, const UnsmoothedMap &map, ImageView<const float> smooth)
        : of_(of), map_(map), smooth_(smooth), r_(of.options_.radius_px) {}

    /// Begins with row v, at least one radius from the first row.
    void start(int v) {
        std::ranges::fill(of_.sums_, 0.0f);
        std::ranges::fill(of_.narrow_.pixels(), 0.0f);
        for (int row = v - r_; row <= v + r_; ++row)
            load(row);
    }
    /// Goes on to row v, which is the row after the last.
    void next(int v) { load(v + r_); }
    /// Calls visit(u, difference, mean) for all pixels of row v that have whole windows.
    template <class Visit>
    void for_each(int v, const Visit &visit) const {
        const int w = smooth_.width();
        const float *difference = of_.narrow_.row(v % of_.narrow_.height());
        const float *sums = of_.sums_.data();
        const auto share = 1 / static_cast<float>((2 * r_ + 1) * (2 * r_ + 1));
        float sum = 0;
        for (int u = 0; u < 2 * r_ && u < w; ++u)
            sum += sums[u];
        for (int u = r_; u < w - r_; ++u) {
            sum += sums[u + r_];
            visit(u, difference[u], share * sum);
            sum -= sums[u - r_];
        }
    }

private:
    /// Row v instead of the one that was loaded longest ago.
    void load(int v) {
        const int w = smooth_.width(), h = smooth_.height();
        float *row = of_.narrow_.row(v % of_.narrow_.height());
        for (int u = 0; u < w; ++u)
            of_.sums_[static_cast<std::size_t>(u)] -= row[u];
        if (v < r_ || v >= h - r_) { // smoothed by neither
            std::fill_n(row, w, 0.0f);
            return;
        }
        of_.smooth_line(map_, v, r_ / 2, row);
        const float *wide = smooth_.row(v);
        for (int u = 0; u < w; ++u) {
            row[u] = u >= r_ && u < w - r_ ? row[u] - wide[u] : 0;
            of_.sums_[static_cast<std::size_t>(u)] += row[u];
        }
    }

    SurfaceSmoothing &of_;
    const UnsmoothedMap &map_;
    ImageView<const float> smooth_;
    int r_;
};

// On planes the mean difference between narrow and wide windows is noise, whose deviation is the
// same share of a reading's sigma everywhere; the median over the map tells that share. Where the
// mean difference is more than three of its deviations the surface is bent: there the narrow
// window's value is taken.
void SurfaceSmoothing::keep_creases(const UnsmoothedMap &map, ImageView<float> smooth) {
    constexpr int bins_per_sigma = 256;
    constexpr float deviations = 3;
    const int h = smooth.height(), r = options_.radius_px;
    NarrowWindows windows(*this, map, smooth);
    std::array<int, bins_per_sigma + 1> histogram{};
    int count = 0;
    for (int v = 2 * r; v < h - 2 * r; v += 4 * r) {
        windows.start(v);
        windows.for_each(v, [&](int u, float /*difference*/, float mean) {
            const float z = smooth(u, v);
            if (z == 0.0f || map.edge_distance(u, v) < far_from_edge)
                return;
            const float sigmas = std::min(std::abs(mean) / map.noise.sigma(z), 1.0f);
            ++histogram[static_cast<std::size_t>(bins_per_sigma * sigmas)];
            ++count;
        });
    }
    if (count == 0)
        return;
    const std::size_t median = median_bin(histogram, count);
    const float least = deviations / gaussian::median_absolute *
                        (static_cast<float>(median) + 0.5f) / static_cast<float>(bins_per_sigma);
    for (int v = r; v < h - r; ++v) {
        if (v == r)
            windows.start(v);
        else
            windows.next(v);
        float *z = smooth.row(v);
        windows.for_each(v, [&](int u, float difference, float mean) {
            if (z[u] != 0.0f && std::abs(mean) > least * map.noise.sigma(z[u]))
                z[u] += difference;
        });
    }
}

} // namespace afterglow
