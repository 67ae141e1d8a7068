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
    auto confidence = table.begin();
    for (int d = 0; d <= warped_edge_mask; ++d)
        for (int b = 0; b < reading_bins; ++b)
            *confidence++ = estimated_confidence(
                error.misplaced +
                error_scale * pixel_error(error, surface.noise(), options_.error.shared_noise,
                                          (static_cast<float>(b) + 0.5f) * reading_bin_m, d));
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
    constexpr int most_px = 4 * OpenTiles::tile_px;
    std::array<std::uint16_t, most_px> readings, classes;
    WarpedRow row;
    row.x0 = static_cast<float>(-camera_.cx / camera_.fx);
    row.dx = static_cast<float>(1 / camera_.fx);
    row.y = static_cast<float>((v - camera_.cy) / camera_.fy);
    row.shape = correction_.shape;
    int count = 0;
    for (int first = begin; first < end; first += most_px) {
        row.pixels = warp_.result().row(v) + first;
        row.first_column = first;
        row.count = std::min(most_px, end - first);
        find_readings(row, readings.data(), classes.data());
        std::uint16_t *depth = depth_.row(v) + first;
        std::uint8_t *confidence = confidence_.row(v) + first;
        for (int i = 0; i < row.count; ++i) {
            if (depth[i] != 0 || row.pixels[i] == 0)
                continue;
            depth[i] = readings[static_cast<std::size_t>(i)];
            confidence[i] = table[classes[static_cast<std::size_t>(i)]];
            ++count;
        }
    }
    return count;
}

/// Calls visit(x, y, confidence) for each cell of the map, MotionMask::cell_px wide and high.
template <class Visit>
void DepthComposer::for_each_cell(const Visit &visit) {
    constexpr int size = MotionMask::cell_px;
    for (int y = 0; y * size < camera_.height; ++y)
        for (int x = 0; x * size < camera_.width; ++x)
            visit(x, y,
                  ImageView<std::uint8_t>(confidence_.row(y * size) + x * size,
                                          std::min(size, camera_.width - x * size),
                                          std::min(size, camera_.height - y * size),
                                          confidence_.width()));
}

void DepthComposer::distrust(const MotionMask &mask, float relative_error) {
    const std::uint8_t most = estimated_confidence(relative_error);
    for_each_cell([&](int x, int y, ImageView<std::uint8_t> cell) {
        if (mask.moving()(x, y) == 0)
            return;
        for (int v = 0; v < cell.height(); ++v)
            for (std::uint8_t *c = cell.row(v), *end = c + cell.width(); c < end; ++c)
                *c = std::min(*c, most);
    });
}

void DepthComposer::distrust(const LocalErrors &errors, float scale) {
    std::array<std::uint8_t, 256> lowered;
    for_each_cell([&](int x, int y, ImageView<std::uint8_t> cell) {
        const float local = scale * errors.expected()(x, y);
        if (local < confidence_step)
            return;
        std::uint8_t least = measured_confidence, most = no_confidence;
        for (int v = 0; v < cell.height(); ++v)
            for (int u = 0; u < cell.width(); ++u) {
                least = std::min(least, cell(u, v));
                most = std::max(most, cell(u, v));
            }
        for (int c = least; c <= most; ++c)
            lowered[static_cast<std::size_t>(c)] =
                c == no_confidence ? no_confidence
                                   : estimated_confidence(std::hypot(
                                         expected_error(static_cast<std::uint8_t>(c)), local));
        for (int v = 0; v < cell.height(); ++v)
            for (std::uint8_t *c = cell.row(v), *end = c + cell.width(); c < end; ++c)
                *c = lowered[*c];
    });
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
