// SPDX-License-Identifier: Apache-2.0
#include "core/rig/depth_resampler.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

namespace afterglow {
namespace {

/// From the upper left of four pixels to the nearest of them.
std::ptrdiff_t nearest_of(std::uint8_t right, std::uint8_t down, int stride) {
    return (right >= Tap::one / 2 ? 1 : 0) + (down >= Tap::one / 2 ? stride : 0);
}

/// Neighbours that differ by more than this share of the nearer one lie on two surfaces.
constexpr int surface_share = 24;

bool is_step(int near, int far) {
    return far - near > near / surface_share + 10;
}

} // namespace

DepthResampler::DepthResampler(const CameraModel &from, const CameraModel &to)
    : from_width_(from.pinhole.width), from_height_(from.pinhole.height),
      to_width_(to.pinhole.width), to_height_(to.pinhole.height),
      taps_(static_cast<std::size_t>(to_width_) * static_cast<std::size_t>(to_height_)) {
    const int w = from_width_, h = from_height_;
    std::size_t i = 0;
    for (int v = 0; v < to_height_; ++v)
        for (int u = 0; u < to_width_; ++u, ++i) {
            const auto ray = to.ray(u, v);
            if (!ray)
                continue;
            const auto at = pixel_seen(from, Eigen::Vector3d{ray->x(), ray->y(), 1});
            // A pixel reaches half of its side beyond its centre.
            if (!at ||
                !(at->x() >= -0.5 && at->y() >= -0.5 && at->x() < w - 0.5 && at->y() < h - 0.5))
                continue;
            taps_[i] = tap_at(at->cwiseMax(0).cwiseMin(Eigen::Vector2d(w - 1, h - 1)), w, h);
        }
}

int DepthResampler::run(DepthView from, ImageView<const std::uint8_t> from_confidence,
                        ImageView<std::uint16_t> to, ImageView<std::uint8_t> to_confidence,
                        WorkerPool &pool) const {
    assert(from.width() == from_width_ && from.height() == from_height_ &&
           from.stride() == from_width_);
    assert(to.width() == to_width_ && to.height() == to_height_);
    const int w = from_width_;
    std::atomic<int> covered = 0;
    pool.run_strips(to_height_, [&](int first, int end) {
        int count = 0;
        for (int v = first; v < end; ++v) {
            const Tap *tap = taps_.data() + static_cast<std::ptrdiff_t>(v) * to_width_;
            std::uint16_t *out = to.row(v);
            std::uint8_t *confidence = to_confidence.empty() ? nullptr : to_confidence.row(v);
            for (int u = 0; u < to_width_; ++u, ++tap) {
                out[u] = 0;
                if (confidence)
                    confidence[u] = 0;
                if (tap->offset < 0)
                    continue;
                const std::uint16_t *p = from.data() + tap->offset;
                const int a = p[0], b = p[1], c = p[w], d = p[w + 1];
                const std::ptrdiff_t nearest = nearest_of(tap->right, tap->down, w);
                if (p[nearest] == 0)
                    continue;
                const int near = std::min(std::min(a, b), std::min(c, d));
                const int far = std::max(std::max(a, b), std::max(c, d));
                if (near != 0 && !is_step(near, far)) {
                    const int upper = a * (Tap::one - tap->right) + b * tap->right;
                    const int lower = c * (Tap::one - tap->right) + d * tap->right;
                    out[u] =
                        static_cast<std::uint16_t>((upper * (Tap::one - tap->down) +
                                                    lower * tap->down + Tap::one * Tap::one / 2) /
                                                   (Tap::one * Tap::one));
                } else {
                    out[u] = p[nearest];
                }
                if (confidence)
                    confidence[u] = from_confidence.data()[tap->offset + nearest];
                ++count;
            }
        }
        covered.fetch_add(count, std::memory_order_relaxed);
    });
    return covered;
}

void DepthResampler::nearest(ImageView<const std::uint16_t> from,
                             ImageView<std::uint16_t> to) const {
    assert(from.width() == from_width_ && from.height() == from_height_ &&
           from.stride() == from_width_);
    assert(to.width() == to_width_ && to.height() == to_height_);
    const Tap *tap = taps_.data();
    for (int v = 0; v < to_height_; ++v)
        for (int u = 0; u < to_width_; ++u, ++tap)
            to(u, v) =
                tap->offset < 0
                    ? std::uint16_t{0}
                    : from.data()[tap->offset + nearest_of(tap->right, tap->down, from_width_)];
}

TofReadings::TofReadings(const CameraModel &tof, bool range_along_ray)
    : z_(tof.pinhole.width, tof.pinhole.height) {
    if (!range_along_ray)
        return;
    for (int v = 0; v < z_.height(); ++v)
        for (int u = 0; u < z_.width(); ++u) {
            const auto ray = tof.ray(u, v);
            z_of_range_.push_back(ray ? static_cast<float>(1 / std::sqrt(1 + ray->squaredNorm()))
                                      : 0.0f);
        }
}

DepthView TofReadings::run(DepthView readings) {
    const int w = z_.width(), h = z_.height();
    assert(readings.width() == w && readings.height() == h);
    for (int v = 0; v < h; ++v) {
        const std::uint16_t *in = readings.row(v);
        std::uint16_t *z = z_.row(v);
        if (z_of_range_.empty()) {
            std::copy_n(in, w, z);
            continue;
        }
        const float *scale = z_of_range_.data() + static_cast<std::ptrdiff_t>(v) * w;
        for (int u = 0; u < w; ++u)
            z[u] = static_cast<std::uint16_t>(static_cast<float>(in[u]) * scale[u] + 0.5f);
    }
    return z_;
}

} // namespace afterglow
