// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/infill.hpp"

#include "eval/experiments/png_data.hpp"
#include "eval/experiments/run_system.hpp"
#include "eval/scoring/metrics.hpp"
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

/// `measured`, and where something was removed from it `filled`.
DepthMap merged(DepthView measured, DepthView removed, DepthView filled) {
    DepthMap all(measured.width(), measured.height());
    for (int v = 0; v < all.height(); ++v)
        for (int u = 0; u < all.width(); ++u)
            all(u, v) = removed(u, v) != 0 ? filled(u, v) : measured(u, v);
    return all;
}

/// Shows a system all frames of a window but the last, of which it measures the first alone; and
/// then the last image. `work`: of each frame.
const Estimate &follow(Pipeline &system, const Sequence &sequence, std::size_t first, int work,
                       Watch &watch) {
    for (std::size_t k = first; k < first + gap; ++k) {
        const Sequence::Frame &frame = sequence.frames[k];
        system.track(frame.luma, frame.t_ns);
        if (k == first)
            system.measure(frame.measured);
        watch.tick(work);
    }
    const Sequence::Frame &last = sequence.frames[first + gap];
    return system.track(last.luma, last.t_ns);
}

/// One trial: what was blind in the last frame of a window, and what is made of it.
struct Trial {
    DepthMap left;       ///< what the camera still sees
    DepthErrors overlap; ///< of the estimate, where the camera sees
    DepthErrors filled;  ///< of what is given, where it does not
    DepthMap given;      ///< measured and filled in
};

/// The paper's system has no infill of its own: where the camera sees nothing it gives its
/// estimate. afterglow publishes such pixels with the measured ones.
Trial try_infill(const Sequence &sequence, const SystemDescription &description, bool furthest,
                 std::size_t first, WorkerPool &pool, Watch &watch) {
    const Tuned own = tuned(description, own_setting(description));
    const auto pipeline = system_factory(
        description, {.options = own.estimator, .pool = pool, .truth = {}})(sequence.camera);
    const Estimate &estimate = follow(*pipeline, sequence, first, work_of(description), watch);
    Trial trial;
    DepthMap removed;
    trial.left = take_away(sequence.frames[first + gap].measured, furthest, removed);
    trial.overlap = compare_depth(estimate.depth, trial.left);
    trial.given = description.name == "default"
                      ? merged(trial.left, removed, pipeline->measure(trial.left).depth)
                      : merged(trial.left, removed, estimate.depth);
    trial.filled = compare_depth(trial.given, removed);
    return trial;
}

void add_pictures(std::vector<Picture> &pictures, const Trial &trial, const DepthRange &range,
                  const std::string &dataset, const std::string &reason) {
    const std::string group = dataset + ", infilling";
    pictures.push_back(depth_picture(group, reason + ": what the camera sees", trial.left, range));
    pictures.push_back(depth_picture(
        group, fmt::format("given back, MRE {:.2f} %", trial.filled.mre), trial.given, range));
}

} // namespace

double infill_work() {
    return 2.0 * (work_of(*find_system("paper")) + work_of(*find_system("default")));
}

Infill infill(const Sequence &sequence, int workers, Watch &watch) {
    Infill result;
    WorkerPool pool(workers);
    for (const char *name : {"paper", "default"}) {
        const SystemDescription &system = *find_system(name);
        for (const char *reason : reasons) {
            const bool furthest = reason == reasons[0];
            Trials trials;
            for (std::size_t first = 0; first + gap < sequence.frames.size(); first += gap) {
                if (Watch::stopped())
                    return result;
                const Trial trial = try_infill(sequence, system, furthest, first, pool, watch);
                if (trial.overlap.pixels > 0)
                    trials.overlap.push_back(trial.overlap.mre);
                if (trial.filled.pixels > 0)
                    trials.filled_mre.push_back(trial.filled.mre);
                trials.filled.push_back(trial.filled.coverage());
                if (first == 0 && system.name == "default")
                    add_pictures(result.pictures, trial, depth_range(sequence.frames[gap].measured),
                                 sequence.name, reason);
            }
            if (!trials.filled.empty())
                result.scores.push_back(score_of(trials, sequence, name, reason));
        }
    }
    return result;
}

} // namespace afterglow
