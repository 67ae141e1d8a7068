// SPDX-License-Identifier: Apache-2.0
#include "capture/depth_pairing.hpp"

#include <algorithm>
#include <cstddef>

namespace afterglow {
namespace {

/// More maps than a driver can have kept while the light was dark.
constexpr int max_stale_maps = 16;

/// Percent of the pixels that have depth.
double coverage(const DepthMap &depth) {
    const auto pixels = depth.pixels();
    const auto holes = std::count(pixels.begin(), pixels.end(), std::uint16_t{0});
    return 100.0 * static_cast<double>(static_cast<std::ptrdiff_t>(pixels.size()) - holes) /
           static_cast<double>(std::max<std::size_t>(pixels.size(), 1));
}

} // namespace

DepthPairing::DepthPairing(const Pairing &pairing, const Intrinsics &camera)
    : pairing_(pairing), camera_(camera),
      warmup_(pairing.warmup_maps, camera.width, camera.height) {
    map_.depth = DepthMap(camera.width, camera.height);
}

void DepthPairing::relit() {
    kept_ = false;
    warmup_.relit();
}

Capture DepthPairing::read(TofSource &tof, Illuminator &light, std::int64_t t_ns,
                           const Estimate &expected) {
    const auto deadline = std::chrono::steady_clock::now() + pairing_.wait;
    for (int attempt = 0; attempt < max_stale_maps; ++attempt) {
        if (const Capture capture = next(tof, deadline); capture != Capture::frame)
            return capture;
        const std::chrono::nanoseconds late_by(t_ns - map_.t_ns);
        if (late_by > pairing_.tolerance || !light.was_lit(map_.t_ns))
            continue;
        if (late_by >= -pairing_.tolerance)
            return examine(expected);
        if (late_by < -pairing_.furthest_ahead)
            return damaged("the depth map belongs to no image");
        kept_ = true;
        break;
    }
    return Capture::none;
}

Capture DepthPairing::next(TofSource &tof, std::chrono::steady_clock::time_point deadline) {
    if (kept_) {
        kept_ = false;
        return Capture::frame;
    }
    const std::chrono::nanoseconds left = deadline - std::chrono::steady_clock::now();
    const Capture capture = tof.read(map_, std::max(left, std::chrono::nanoseconds(0)));
    if (capture == Capture::damaged || capture == Capture::lost)
        problem_ = tof.problem();
    if (capture != Capture::frame)
        return capture;
    if (map_.depth.width() != camera_.width || map_.depth.height() != camera_.height) {
        map_.depth = DepthMap(camera_.width, camera_.height);
        return damaged("the depth map has not the size of the camera's maps");
    }
    if (!map_.amplitude.empty() && !map_.amplitude.view().same_size(map_.depth.view()))
        return damaged("the amplitude has not the size of its depth map");
    drop_dim();
    map_.t_ns += pairing_.delay.count();
    return Capture::frame;
}

void DepthPairing::drop_dim() {
    const auto depth = map_.depth.pixels();
    const auto amplitude = map_.amplitude.pixels();
    for (std::size_t i = 0; i < amplitude.size(); ++i)
        if (amplitude[i] < pairing_.least_amplitude)
            depth[i] = 0;
}

Capture DepthPairing::examine(const Estimate &expected) {
    if (coverage(map_.depth) < min_measured_coverage)
        return damaged("the depth map is all but empty");
    return warmup_.is_settled(map_.depth, expected) ? Capture::frame : Capture::none;
}

Capture DepthPairing::damaged(std::string_view why) {
    problem_ = why;
    return Capture::damaged;
}

} // namespace afterglow
