// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_composer.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace afterglow {
namespace {

constexpr int most_candidates = 16;
/// Keyframes of which less than this is in view are not worth a warp.
constexpr float least_visible_share = 0.1f;

struct Candidate {
    int keyframe;
    float visible_share;
};

} // namespace

DepthComposer::DepthComposer(const Views &views, const KeyframeOptions &options, WorkerPool &pool)
    : views_(views), camera_(views.published), options_(options), pool_(pool),
      warp_(views.surface, views.published, options.warp), depth_(camera_.width, camera_.height),
      confidence_(depth_.width(), depth_.height()),
      compared_(MotionMask::cells(camera_.width), MotionMask::cells(camera_.height)) {}

void DepthComposer::clear() {
    misplaced_ = 0;
    std::ranges::fill(depth_.pixels(), std::uint16_t{0});
    std::ranges::fill(confidence_.pixels(), std::uint8_t{0});
    covered_ = 0;
}

void DepthComposer::compose(const KeyframeSet &keyframes, int reference, const Pose &now,
                            const Alignment &alignment, const Twist &while_read, int enough,
                            const DepthCorrection &correction, float error_scale) {
    correction_ = correction;
    clear();
    std::array<Candidate, most_candidates> candidates{};
    int count = 0;
    for (int i = 0; i < keyframes.size() && count < most_candidates; ++i) {
        const Pose pose = now * keyframes[i].depth_from_world.inverse();
        const float share = i == reference ? 2.0f
                                           : visible_share(keyframes[i].surface, views_.surface,
                                                           pose, views_.published);
        if (share > least_visible_share)
            candidates[static_cast<std::size_t>(count++)] = {i, share};
    }
    std::sort(
        candidates.begin(), candidates.begin() + count,
        [](const Candidate &a, const Candidate &b) { return a.visible_share > b.visible_share; });
    for (int i = 0; i < std::min(count, options_.compose.maps_per_frame); ++i) {
        const bool first = i == 0;
        if (!first && covered_ >= enough)
            break;
        const Keyframe &k = keyframes[candidates[static_cast<std::size_t>(i)].keyframe];
        const Pose pose = now * k.depth_from_world.inverse();
        RollingShutter shutter;
        if (views_.publishes_tracking()) { // other cameras show one instant
            if (views_.readout_s > 0)
                shutter.motion = while_read;
            else if (first)
                shutter.skew = views_.surface_from_tracking.R.cast<float>() * alignment.skew;
        }
        warp_.run(k.surface, pose, depth_, pool_, shutter);
        merge(map_error(k.surface, views_, pose, alignment.covariance, options_.error,
                        k.calibration_shift),
              k.surface, error_scale);
    }
}

/// Writes what was warped into the pixels that are still empty.
void DepthComposer::merge(const MapError &error, const DepthSurface &surface, float error_scale) {
    misplaced_ = std::max(misplaced_, error.misplaced);
    ConfidenceTable table;
    for (int d = 0; d <= DepthSurface::far_from_edge; ++d)
        for (int b = 0; b < z_bins; ++b)
            table[static_cast<std::size_t>(d)][static_cast<std::size_t>(b)] = estimated_confidence(
                error.misplaced +
                error_scale * pixel_error(error, surface.noise(), options_.error.shared_noise,
                                          (static_cast<float>(b) + 0.5f) * z_bin_m, d));
    std::atomic<int> added = 0;
    const int rows = camera_.height, n = pool_.size();
    pool_.run([&](int worker) {
        int count = 0;
        for (int v = rows * worker / n; v < rows * (worker + 1) / n; ++v)
            warp_.open().for_each_run(
                v, [&](int begin, int end) { count += merge_row(v, begin, end, table); });
        added.fetch_add(count, std::memory_order_relaxed);
    });
    covered_ += added;
}

int DepthComposer::merge_row(int v, int begin, int end, const ConfidenceTable &table) {
    const WarpedPixel *in = warp_.result().row(v);
    std::uint16_t *depth = depth_.row(v);
    std::uint8_t *confidence = confidence_.row(v);
    const float dx = static_cast<float>(1 / camera_.fx);
    const float x0 = static_cast<float>(-camera_.cx / camera_.fx);
    const float y = static_cast<float>((v - camera_.cy) / camera_.fy);
    int count = 0;
    for (int first = begin; first < end; first += OpenTiles::tile_px) {
        std::array<float, OpenTiles::tile_px> z;
        const int n = std::min(OpenTiles::tile_px, end - first);
        for (int i = 0; i < n; ++i)
            z[static_cast<std::size_t>(i)] =
                warped_z(in[first + i]) /
                correction_.scale(x0 + dx * static_cast<float>(first + i), y);
        for (int i = 0; i < n; ++i) {
            const int u = first + i;
            if (depth[u] != 0 || in[u] == 0)
                continue;
            const float reading = z[static_cast<std::size_t>(i)];
            const int bin = std::min(static_cast<int>(reading * (1.0f / z_bin_m)), z_bins - 1);
            depth[u] = static_cast<std::uint16_t>(reading * 1000.0f + 0.5f);
            confidence[u] = table[static_cast<std::size_t>(in[u] & warped_edge_mask)]
                                 [static_cast<std::size_t>(bin)];
            ++count;
        }
    }
    return count;
}

void DepthComposer::distrust(const MotionMask &mask, float relative_error) {
    const std::uint8_t most = estimated_confidence(relative_error);
    constexpr int cell = MotionMask::cell_px;
    for (int v = 0; v < camera_.height; ++v) {
        const std::uint8_t *moving = mask.moving().row(v / cell);
        std::uint8_t *confidence = confidence_.row(v);
        for (int u = 0; u < camera_.width; ++u)
            if (moving[u / cell])
                confidence[u] = std::min(confidence[u], most);
    }
}

void DepthComposer::distrust(const LocalErrors &errors, float scale) {
    constexpr int cell = LocalErrors::cell_px;
    const ImageView<const float> added = errors.expected();
    std::array<std::uint8_t, 256> lowered;
    for (int y = 0; y < added.height(); ++y)
        for (int x = 0; x < added.width(); ++x) {
            const float local = scale * added(x, y);
            if (local < confidence_step)
                continue;
            lowered[no_confidence] = no_confidence;
            for (std::size_t c = 1; c < lowered.size(); ++c)
                lowered[c] = estimated_confidence(
                    std::hypot(expected_error(static_cast<std::uint8_t>(c)), local));
            const int right = std::min((x + 1) * cell, camera_.width);
            const int bottom = std::min((y + 1) * cell, camera_.height);
            for (int v = y * cell; v < bottom; ++v)
                for (int u = x * cell; u < right; ++u)
                    confidence_(u, v) = lowered[confidence_(u, v)];
        }
}

ImageView<const ComparedErrors> DepthComposer::compare(DepthView measured) {
    constexpr int step = 2, cell = MotionMask::cell_px;
    std::ranges::fill(compared_.pixels(), ComparedErrors{});
    for (int v = 0; v < camera_.height; v += step)
        for (int u = 0; u < camera_.width; u += step) {
            const int truth = measured(u, v), shown = depth_(u, v);
            if (truth == 0 || shown == 0)
                continue;
            ComparedErrors &errors = compared_(u / cell, v / cell);
            errors.true_sum += std::abs(shown - truth) / static_cast<double>(truth);
            errors.expected_sum +=
                std::max(expected_error(confidence_(u, v)) - misplaced_, confidence_step);
            ++errors.pixels;
        }
    return compared_;
}

void DepthComposer::overlay(DepthView measured) {
    for (int v = 0; v < camera_.height; ++v) {
        const std::uint16_t *in = measured.row(v);
        std::uint16_t *depth = depth_.row(v);
        std::uint8_t *confidence = confidence_.row(v);
        for (int u = 0; u < camera_.width; ++u) {
            if (in[u] == 0)
                continue;
            covered_ += depth[u] == 0;
            depth[u] = in[u];
            confidence[u] = measured_confidence;
        }
    }
}

float DepthComposer::expected_mre() const {
    std::array<int, 256> histogram{};
    for (const std::uint8_t c : confidence_.pixels())
        ++histogram[c];
    double sum = 0;
    int count = 0;
    for (int c = 1; c < 256; ++c) {
        const int pixels = histogram[static_cast<std::size_t>(c)];
        sum += static_cast<double>(pixels) * expected_error(static_cast<std::uint8_t>(c));
        count += pixels;
    }
    return count > 0 ? static_cast<float>(100 * sum / count) : 100.0f;
}

} // namespace afterglow
