// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/depth_composer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace afterglow {
namespace {

/// Keyframes of which less than this is in view are not worth a warp.
constexpr float least_visible_share = 0.1f;

/// A map is drawn anew when its pixels show what is farther than this from what they should, or
/// nearer or farther by this share of its depth.
constexpr float same_place_px = 0.25f, same_depth = 0.001f;

/// A map's expected error is worked out from the confidences of one row in so many: they change
/// little from row to row.
constexpr int summed_row = 8;

/// Confidences of a cell are made anew when its local error has changed by this factor.
constexpr float noticed_growth = 1.1f;

/// The pixels of one of MotionMask's cells.
template <class T>
ImageView<T> cell_of(ImageView<T> image, int x, int y) {
    constexpr int size = MotionMask::cell_px;
    return part_of(image, x * size, y * size, std::min(size, image.width() - x * size),
                   std::min(size, image.height() - y * size));
}

/// By how much a confidence is less for an additional error, relative: the expected error is linear
/// in the confidence; less than a step of it is left out.
std::uint8_t steps_less(float error) {
    const float steps = std::min(error / confidence_step, 254.0f);
    return steps < 1 ? 0 : static_cast<std::uint8_t>(std::ceil(steps));
}

/// What the confidences promise, percent, in the mean; 100 without.
float mean_error(const ConfidenceSum &of) {
    if (of.pixels == 0)
        return 100;
    // The expected error is linear in the confidence, and 0 is no confidence.
    const double mean = static_cast<double>(of.sum) / of.pixels;
    return static_cast<float>(100 * confidence_step * (measured_confidence - mean));
}

} // namespace

DepthComposer::DepthComposer(const Views &views, const KeyframeOptions &options, WorkerPool &pool)
    : views_(views), camera_(views.published), options_(options), pool_(pool),
      warp_(views.surface, views.published, options.warp, pool),
      depth_(camera_.width, camera_.height), classes_(camera_.width, camera_.height),
      places_(warp_.readings().width(), warp_.readings().height(), places_differ),
      confidence_(camera_.width, camera_.height), drawn_depth_(depth_), drawn_classes_(classes_),
      further_(options.compose.maps_per_frame > 1 ? depth_ : DepthMap()),
      further_edges_(further_.width(), further_.height()),
      compared_(MotionMask::cells(camera_.width), MotionMask::cells(camera_.height)),
      cells_(compared_.width(), compared_.height()) {}

void DepthComposer::clear() {
    displaced_ = false;
    misplaced_ = 0;
    std::ranges::fill(depth_.pixels(), std::uint16_t{0});
    std::ranges::fill(confidence_.pixels(), std::uint8_t{0});
    covered_ = left_empty_ = layer_count_ = 0;
    judged_ = independent_ = {};
    for (Cell &cell : cells_.pixels())
        cell.unfinished = false;
}

void DepthComposer::compose(const KeyframeSet &keyframes, int reference, const Pose &now,
                            const Alignment &alignment, const Twist &rate, int enough,
                            const DepthCorrection &correction) {
    const auto pose_of = [&](const Keyframe &k) { return now * k.depth_from_world.inverse(); };
    const Keyframe &first = keyframes[reference];
    const Drawn next = {first.t_ns, pose_of(first), shutter(alignment, views_.readout_s * rate)};
    drawn_anew_ = !looks_as_drawn(first, next);
    if (!drawn_anew_)
        return;
    displaced_ = all_kept_ = false;
    for (Cell &cell : cells_.pixels())
        cell.kept = cell.displaced = false;
    drawn_ = next;
    covered_ = left_empty_ = layer_count_ = 0;
    misplaced_ = 0;
    const Eigen::Matrix<float, 6, 6> covariance =
        alignment.covariance +
        lag_covariance(first.rate, rate, alignment.pose, options_.error.lag_jitter_s);
    std::array<int, most_layers> room{};
    for (const int i : pick_keyframes(keyframes, reference, now, room)) {
        const Keyframe &k = keyframes[i];
        const Pose pose = pose_of(k);
        if (layer_count_ == 0) {
            covered_ = warp_.run(k.surface, pose, depth_, classes_, correction, next.shutter);
            find_places();
        } else if (covered_ < enough) {
            // The skew is known of the reference alone.
            warp_.run(k.surface, pose, further_, further_edges_, correction,
                      {.motion = next.shutter.motion});
            fill_in();
        } else {
            break;
        }
        Layer &layer = layers_[static_cast<std::size_t>(layer_count_++)];
        layer.noise = k.surface.noise();
        layer.error =
            map_error(k.surface, views_, pose, covariance, options_.error, k.calibration_shift);
        // From where the TOF camera was to where it would measure now.
        const Pose moved = views_.published_from_surface().inverse() * pose;
        layer.uncorrelated =
            uncorrelated_share(mean_displacement(k.surface, views_.surface, moved));
        misplaced_ = std::max(misplaced_, layer.error.misplaced);
    }
}

DepthView DepthComposer::drawn() {
    if (!displaced_)
        return depth_;
    if (!std::exchange(all_kept_, true))
        keep(0, depth_.width(), 0, depth_.height());
    return drawn_depth_;
}

/// Copies the cells that touch a rectangle of the map's pixels to drawn_depth_ and so on, before
/// one of them is displaced.
void DepthComposer::keep(int left, int right, int top, int bottom) {
    constexpr int size = MotionMask::cell_px;
    for (int y = top / size; y * size < bottom; ++y)
        for (int x = left / size; x * size < right; ++x) {
            if (std::exchange(cells_(x, y).kept, true))
                continue;
            copy_pixels(cell_of(depth_.view(), x, y), cell_of(drawn_depth_.view(), x, y));
            copy_pixels(cell_of(classes_.view(), x, y), cell_of(drawn_classes_.view(), x, y));
        }
}

void DepthComposer::displace(const ResidualFlow &flow) {
    if (displaced_ && !flow.changed())
        return;
    restore();
    if (!flow.any())
        return;
    displaced_ = true;
    drawn_covered_ = covered_;
    const ImageView<const ResidualFlow::Shift> shifts = flow.shifts();
    for (int y = 0; y < shifts.height(); ++y) {
        const ResidualFlow::Shift *const row = shifts.row(y), *const row_end = row + shifts.width();
        for (const ResidualFlow::Shift *begin = row; begin != row_end;) {
            const auto *const end = std::find_if(
                begin, row_end, [&](const ResidualFlow::Shift &shift) { return shift != *begin; });
            if (*begin != ResidualFlow::Shift{})
                displace_run(static_cast<int>(begin - row) << flow.level(),
                             static_cast<int>(end - row) << flow.level(), y << flow.level(),
                             (y + 1) << flow.level(), *begin);
            begin = end;
        }
    }
}

/// Gives the pixels of a rectangle what the map shows elsewhere.
void DepthComposer::displace_run(int left, int right, int top, int bottom,
                                 const ResidualFlow::Shift &shift) {
    keep(left, right, top, bottom);
    for (int x = left / MotionMask::cell_px; x <= (right - 1) / MotionMask::cell_px; ++x) {
        Cell &cell = cells_(x, top / MotionMask::cell_px);
        cell.displaced = cell.changed = true;
    }
    const int first = std::clamp(-shift.u, left, right);
    const int end = std::clamp(depth_.width() - shift.u, first, right);
    if (first < end)
        keep(first + shift.u, end + shift.u, std::max(top + shift.v, 0),
             std::min(bottom + shift.v, depth_.height()));
    const auto count = [&](const std::uint16_t *row) {
        return static_cast<int>(
            std::count_if(row + left, row + right, [](std::uint16_t mm) { return mm != 0; }));
    };
    for (int v = top; v < bottom; ++v) {
        std::uint16_t *const depth = depth_.row(v);
        std::uint8_t *const classes = classes_.row(v);
        const int drawn = count(depth);
        covered_ -= drawn;
        if (shift == ResidualFlow::Shift::nowhere())
            left_empty_ += drawn;
        std::fill(depth + left, depth + right, std::uint16_t{0});
        std::fill(classes + left, classes + right, std::uint8_t{0});
        const int from = v + shift.v;
        if (from < 0 || from >= depth_.height())
            continue;
        std::copy(drawn_depth_.row(from) + shift.u + first, drawn_depth_.row(from) + shift.u + end,
                  depth + first);
        std::copy(drawn_classes_.row(from) + shift.u + first,
                  drawn_classes_.row(from) + shift.u + end, classes + first);
        covered_ += count(depth);
    }
}

/// Undoes displace().
void DepthComposer::restore() {
    if (!std::exchange(displaced_, false))
        return;
    covered_ = drawn_covered_;
    left_empty_ = 0;
    for (int y = 0; y < cells_.height(); ++y)
        for (int x = 0; x < cells_.width(); ++x) {
            Cell &cell = cells_(x, y);
            if (!std::exchange(cell.displaced, false))
                continue;
            cell.changed = true;
            copy_pixels(cell_of(drawn_depth_.view(), x, y), cell_of(depth_.view(), x, y));
            copy_pixels(cell_of(drawn_classes_.view(), x, y), cell_of(classes_.view(), x, y));
        }
}

/// Of the map to be drawn: cameras other than the tracking one show one instant.
RollingShutter DepthComposer::shutter(const Alignment &alignment, const Twist &while_read) const {
    if (!views_.publishes_tracking())
        return {};
    if (views_.readout_s > 0)
        return {.motion = while_read};
    return {.skew = views_.surface_from_tracking.R.cast<float>() * alignment.skew};
}

/// The reference and, if several maps are to be drawn, other keyframes, those first that see most
/// of the view. Returns the part of `picked` that is used.
std::span<const int> DepthComposer::pick_keyframes(const KeyframeSet &keyframes, int reference,
                                                   const Pose &now,
                                                   std::span<int, most_layers> picked) const {
    picked.front() = reference;
    const int most = options_.compose.maps_per_frame;
    if (most <= 1)
        return picked.first(1);
    struct Candidate {
        int keyframe;
        float visible_share;
    };
    std::array<Candidate, most_layers> others{};
    int count = 0;
    for (int i = 0; i < keyframes.size() && count < most_layers - 1; ++i) {
        if (i == reference)
            continue;
        const Pose pose = now * keyframes[i].depth_from_world.inverse();
        const float share =
            visible_share(keyframes[i].surface, views_.surface, pose, views_.published);
        if (share > least_visible_share)
            others[static_cast<std::size_t>(count++)] = {i, share};
    }
    std::sort(others.begin(), others.begin() + count, [](const Candidate &a, const Candidate &b) {
        return a.visible_share > b.visible_share;
    });
    count = std::min(count, most - 1);
    std::transform(others.begin(), others.begin() + count, picked.begin() + 1,
                   [](const Candidate &candidate) { return candidate.keyframe; });
    return picked.first(static_cast<std::size_t>(count) + 1);
}

/// Whether the map drawn last would hardly change, were it drawn again: by where it shows a few
/// points.
bool DepthComposer::looks_as_drawn(const Keyframe &keyframe, const Drawn &next) const {
    constexpr int across = 5;
    if (layer_count_ == 0 || drawn_.t_ns != next.t_ns || options_.compose.maps_per_frame > 1)
        return false;
    const float f = static_cast<float>(camera_.fx);
    const Twist motion = next.shutter.motion - drawn_.shutter.motion;
    const double nearest = keyframe.surface.options().nearest_m;
    // Of the first and the last row, which are half a readout from the middle one.
    const float by_shutter = 0.5f * f *
                             ((next.shutter.skew - drawn_.shutter.skew).norm() +
                              static_cast<float>(motion.tail<3>().norm()) +
                              static_cast<float>(motion.head<3>().norm() / nearest));
    if (!(by_shutter < same_place_px))
        return false;
    const Pose moved = next.pose * drawn_.pose.inverse();
    for (int y = 0; y < across; ++y)
        for (int x = 0; x < across; ++x) {
            const int u = x * (camera_.width - 1) / (across - 1);
            const int v = y * (camera_.height - 1) / (across - 1);
            const double z = depth_(u, v) != 0 ? 1e-3 * depth_(u, v) : 1;
            const Eigen::Vector3d X = moved * camera_.back_project(u, v, z);
            if (!(std::abs(X.z() - z) < same_depth * z &&
                  (camera_.project(X) - Eigen::Vector2d(u, v)).norm() < same_place_px))
                return false;
        }
    return true;
}

/// Finds the tiles whose pixels all have one confidence.
void DepthComposer::find_places() {
    static_assert(judged_tile_px == TileMapping::tile_px);
    const auto place = [](const TileReadings &tile) {
        if (!tile.known())
            return places_differ;
        const int bin = depth_bin(tile.nearest);
        if (tile.farthest >= first_of_bin(bin + 1))
            return places_differ;
        return static_cast<std::uint16_t>(place_in_table(tile.edge_distance, bin));
    };
    std::ranges::transform(warp_.readings().pixels(), places_.pixels().begin(), place);
}

/// Pixels that are still empty get what a further map has.
void DepthComposer::fill_in() {
    std::ranges::replace(places_.pixels(), std::uint16_t{place_in_table(0, 0)}, places_differ);
    for (int v = 0; v < camera_.height; ++v) {
        const std::uint16_t *further = further_.row(v);
        const std::uint8_t *edge = further_edges_.row(v);
        std::uint16_t *depth = depth_.row(v);
        std::uint8_t *of = classes_.row(v);
        for (int u = 0; u < camera_.width; ++u) {
            if (depth[u] != 0 || further[u] == 0)
                continue;
            depth[u] = further[u];
            of[u] = static_cast<std::uint8_t>(edge[u] | layer_count_ * class_layer);
            ++covered_;
        }
    }
}

void DepthComposer::make_tables(const ErrorScales &scales) {
    for (int l = 0; l < layer_count_; ++l) {
        const Layer &layer = layers_[static_cast<std::size_t>(l)];
        for (int d = 1; d <= far_from_edge; ++d)
            for (int bin = 0; bin < depth_bins; ++bin) {
                const PixelError error = pixel_error(
                    layer.error, layer.noise, options_.error.shared_noise, middle_of_bin(bin), d);
                const auto confidence = [&](float uncorrelated) {
                    return estimated_confidence(
                        layer.error.misplaced +
                        error.scaled({uncorrelated * scales.fresh, scales.carried}));
                };
                const auto place =
                    static_cast<std::size_t>(place_in_table(l * class_layer + d, bin));
                table_[place] = confidence(layer.uncorrelated);
                independent_table_[place] = confidence(1);
            }
    }
}

void DepthComposer::judge(const Doubts &doubts, bool all_rows) {
    if (!find_doubts(doubts, all_rows))
        return;
    make_tables(doubts.scales);
    pool_.run(cells_.height(), [&](int y) {
        for (int x = 0; x < cells_.width(); ++x)
            if (cells_(x, y).judge)
                judge_cell(x, y, all_rows);
    });
    judged_ = independent_ = {};
    for (const Cell &cell : cells_.pixels()) {
        judged_ += cell.judged;
        independent_ += cell.independent;
    }
}

void DepthComposer::judge_rest() {
    if (std::ranges::none_of(cells_.pixels(), &Cell::unfinished))
        return;
    pool_.run(cells_.height(), [&](int y) {
        for (int x = 0; x < cells_.width(); ++x)
            if (cells_(x, y).unfinished)
                judge_cell(x, y, true);
    });
}

/// Whether there is a cell to judge.
bool DepthComposer::find_doubts(const Doubts &doubts, bool all_rows) {
    const bool all = drawn_anew_ || doubts.scales != scales_;
    scales_ = doubts.scales;
    bool any = false;
    for (int y = 0; y < cells_.height(); ++y)
        for (int x = 0; x < cells_.width(); ++x) {
            Cell &cell = cells_(x, y);
            const float local = doubts.local ? doubts.local->expected()(x, y) : 0;
            const float noticed =
                std::max(confidence_step, (noticed_growth - 1) * std::min(local, cell.local));
            cell.judge = all || cell.changed || (all_rows && cell.unfinished) ||
                         std::abs(local - cell.local) > noticed;
            cell.changed = false;
            if (!cell.judge)
                continue;
            cell.local = local;
            cell.less = steps_less(local);
            any = true;
        }
    return any;
}

/// Gives a cell's pixels, of all rows or of those that are summed up, their confidences.
void DepthComposer::judge_cell(int x, int y, bool all_rows) {
    Cell &cell = cells_(x, y);
    cell.unfinished = !all_rows;
    const int every = all_rows ? 1 : summed_row;
    const auto rows_of = [&](auto image) { return every_row(cell_of(image, x, y), every); };
    // Where something is displaced, tiles are not as they were drawn.
    constexpr int tiles = MotionMask::cell_px / judged_tile_px;
    ImageView<const std::uint16_t> places;
    if (!cell.displaced)
        places = part_of(places_.view(), x * tiles, y * tiles,
                         std::min(tiles, places_.width() - x * tiles),
                         std::min(tiles, places_.height() - y * tiles));
    const auto depth = rows_of(depth_.view());
    const std::uint16_t middle = depth(depth.width() / 2, depth.height() / 2);
    const ConfidenceSums sums =
        look_up_confidences({depth, rows_of(classes_.view()), places, judged_tile_px / every},
                            {table_.data(), independent_table_.data(), cell.less},
                            depth_bin(middle), summed_row / every, rows_of(confidence_.view()));
    cell.judged = sums.by_table;
    cell.independent = sums.by_other_table;
}

ImageView<const ComparedErrors> DepthComposer::compare(DepthView measured) {
    for (int y = 0; y < compared_.height(); ++y)
        for (int x = 0; x < compared_.width(); ++x)
            compared_(x, y) =
                compare_errors({cell_of(depth_.view(), x, y), cell_of(confidence_.view(), x, y),
                                cell_of(measured, x, y)},
                               misplaced_);
    return compared_;
}

int DepthComposer::overlay(DepthView measured) {
    displaced_ = false;
    left_empty_ = layer_count_ = 0;
    judged_ = {};
    int pixels = 0;
    for (int v = 0; v < camera_.height; ++v) {
        const Overlaid row =
            lay_over(measured.row(v), camera_.width, depth_.row(v), confidence_.row(v));
        pixels += row.measured;
        judged_ += row.covered;
    }
    independent_ = judged_;
    covered_ = judged_.pixels;
    return pixels;
}

float DepthComposer::expected_mre() const {
    return mean_error(judged_);
}

float DepthComposer::independent_mre() const {
    return mean_error(independent_);
}

} // namespace afterglow
