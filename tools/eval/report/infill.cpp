// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/infill.hpp"

#include "core/metrics.hpp"
#include "tools/eval/report/play.hpp"
#include "tools/picture/depth_colors.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr std::size_t gap = 10; ///< frames between the earlier map and the one to be filled
constexpr double taken = 20;    ///< percent of the measured depths
constexpr const char *reasons[] = {"out of range", "saturation"};

/// The map without its furthest or nearest depths; and in `removed` those alone.
DepthMap take_away(DepthView depth, bool furthest, DepthMap &removed) {
    std::vector<double> known;
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u)
            if (depth(u, v) != 0)
                known.push_back(depth(u, v));
    const double limit = percentile(known, furthest ? 100 - taken : taken).value_or(0);
    DepthMap left(depth.width(), depth.height());
    removed = DepthMap(depth.width(), depth.height());
    for (int v = 0; v < depth.height(); ++v)
        for (int u = 0; u < depth.width(); ++u) {
            const bool out = furthest ? depth(u, v) > limit : depth(u, v) < limit;
            (out ? removed : left)(u, v) = depth(u, v);
        }
    return left;
}

struct Trials {
    std::vector<double> overlap, filled_mre, filled;
};

InfillScore score_of(const Trials &trials, const Sequence &sequence, std::string_view system,
                     const char *reason) {
    return {.dataset = sequence.name,
            .system = std::string(system),
            .reason = reason,
            .trials = static_cast<int>(trials.filled.size()),
            .overlap_mre = percentile(trials.overlap, 50),
            .filled_mre = percentile(trials.filled_mre, 50),
            .filled = percentile(trials.filled, 50).value_or(0)};
}

DepthMap merged(DepthView measured, DepthView removed, DepthView estimate) {
    DepthMap all(measured.width(), measured.height());
    for (int v = 0; v < all.height(); ++v)
        for (int u = 0; u < all.width(); ++u)
            all(u, v) = removed(u, v) != 0 ? estimate(u, v) : measured(u, v);
    return all;
}

/// What the last frame of a window is estimated to be, from the measured map of its first alone.
DepthMap estimate_last(const Sequence &sequence, const SystemDescription &system, std::size_t first,
                       WorkerPool &pool, const Watch &watch) {
    Player player(system, {}, sequence.camera, pool);
    DepthMap last(sequence.camera.width, sequence.camera.height);
    for (std::size_t k = first; k <= first + gap; ++k) {
        const Sequence::Frame &frame = sequence.frames[k];
        const Estimate &estimate = player.system->track(frame.luma, frame.t_ns);
        if (k == first)
            player.system->measure(frame.measured);
        else if (k == first + gap)
            for (int v = 0; v < last.height(); ++v)
                std::copy_n(estimate.depth.row(v), last.width(), last.row(v));
        watch.tick();
    }
    return last;
}

} // namespace

int infill_frames(const Sequence &sequence) {
    const std::size_t windows = (sequence.frames.size() - 1) / gap;
    return static_cast<int>(2 * windows * (gap + 1));
}

Infill infill(const Sequence &sequence, int workers, const Watch &watch) {
    Infill result;
    WorkerPool pool(workers);
    for (const char *name : {"paper", "default"}) {
        const SystemDescription &system = *find_system(name);
        Trials trials[2];
        for (std::size_t first = 0; first + gap < sequence.frames.size(); first += gap) {
            if (Watch::stopped())
                return result;
            const DepthMap estimate = estimate_last(sequence, system, first, pool, watch);
            const DepthMap &measured = sequence.frames[first + gap].measured;
            for (int i = 0; i < 2; ++i) {
                DepthMap removed;
                const DepthMap left = take_away(measured, i == 0, removed);
                const DepthErrors overlap = compare_depth(estimate, left);
                const DepthErrors filled = compare_depth(estimate, removed);
                if (overlap.pixels > 0)
                    trials[i].overlap.push_back(overlap.mre);
                if (filled.pixels > 0)
                    trials[i].filled_mre.push_back(filled.mre);
                trials[i].filled.push_back(filled.coverage());
                if (first != 0 || system.name != "default")
                    continue;
                const DepthRange range = depth_range(measured);
                const std::string group = sequence.name + ", " + reasons[i];
                result.pictures.push_back(
                    {group, "what the camera sees", color_depth(left, range)});
                result.pictures.push_back({group, fmt::format("infilled, {:.2f} % off", filled.mre),
                                           color_depth(merged(left, removed, estimate), range)});
            }
        }
        for (int i = 0; i < 2; ++i)
            if (!trials[i].filled.empty())
                result.scores.push_back(score_of(trials[i], sequence, name, reasons[i]));
    }
    return result;
}

} // namespace afterglow
