// SPDX-License-Identifier: Apache-2.0
#include "core/rig/luma_resampler.hpp"

#include <cassert>

namespace afterglow {
namespace {

constexpr double most_pixels_to_one = 1.5;

void halve(LumaView from, ImageView<std::uint8_t> to) {
    for (int v = 0; v < to.height(); ++v) {
        const std::uint8_t *upper = from.row(2 * v);
        const std::uint8_t *lower = from.row(2 * v + 1);
        std::uint8_t *out = to.row(v);
        for (int u = 0; u < to.width(); ++u)
            out[u] = static_cast<std::uint8_t>(
                (upper[2 * u] + upper[2 * u + 1] + lower[2 * u] + lower[2 * u + 1] + 2) >> 2);
    }
}

} // namespace

LumaResampler::LumaResampler(const CameraModel &from, const Intrinsics &to)
    : taps_(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height)),
      result_(to.width, to.height) {
    int level = 0;
    for (double ratio = from.pinhole.fx / to.fx; ratio > most_pixels_to_one; ratio /= 2)
        ++level;
    for (int l = 1; l <= level; ++l)
        halved_.emplace_back(from.pinhole.width >> l, from.pinhole.height >> l);
    CameraModel source = from;
    source.pinhole = from.pinhole.at_level(level);
    const int w = source.pinhole.width, h = source.pinhole.height;
    std::size_t i = 0;
    for (int v = 0; v < to.height; ++v)
        for (int u = 0; u < to.width; ++u, ++i) {
            const auto at =
                pixel_seen(source, Eigen::Vector3d{(u - to.cx) / to.fx, (v - to.cy) / to.fy, 1});
            if (!at || !(at->x() >= 0 && at->y() >= 0 && at->x() <= w - 1 && at->y() <= h - 1))
                continue;
            taps_[i] = tap_at(*at, w, h);
        }
}

LumaView LumaResampler::run(LumaView image) {
    for (Luma &half : halved_) {
        halve(image, half);
        image = half;
    }
    assert(image.stride() == image.width());
    const std::uint8_t *from = image.data();
    const int stride = image.stride();
    std::uint8_t *out = result_.view().data();
    for (const Tap &tap : taps_) {
        if (tap.offset < 0) {
            *out++ = 0;
            continue;
        }
        const std::uint8_t *p = from + tap.offset;
        const int upper = p[0] * (Tap::one - tap.right) + p[1] * tap.right;
        const int lower = p[stride] * (Tap::one - tap.right) + p[stride + 1] * tap.right;
        *out++ = static_cast<std::uint8_t>(
            (upper * (Tap::one - tap.down) + lower * tap.down + Tap::one * Tap::one / 2) /
            (Tap::one * Tap::one));
    }
    return result_;
}

} // namespace afterglow
