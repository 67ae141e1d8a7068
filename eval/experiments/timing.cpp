// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/timing.hpp"

#include "core/base/clock.hpp"
#include "core/paper/grid_flow.hpp"
#include "core/paper/ransac.hpp"
#include "core/paper/reprojection.hpp"
#include "eval/baselines/table_1.hpp"
#include "eval/experiments/run_system.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <ctime>
#include <memory>
#include <opencv2/core/utility.hpp>

namespace afterglow {
namespace {

template <class Job>
double time_ms(Job &&job) {
    const auto start = std::chrono::steady_clock::now();
    job();
    const auto passed = std::chrono::steady_clock::now() - start;
    return std::chrono::duration<double, std::milli>(passed).count();
}

/// CPU time that all threads of the process have used.
double cpu_ms() {
    return 1e-6 * static_cast<double>(clock_ns(CLOCK_PROCESS_CPUTIME_ID));
}

/// Two neighbouring frames of a sequence, and then the next two; round and round.
class Pairs {
public:
    explicit Pairs(const Sequence &sequence) : frames_(sequence.frames) {}
    bool any() const { return frames_.size() > 1; }
    const Sequence::Frame &before() const { return frames_[at_]; }
    const Sequence::Frame &after() const { return frames_[at_ + 1]; }
    void next() { at_ = (at_ + 1) % (frames_.size() - 1); }

private:
    const std::vector<Sequence::Frame> &frames_;
    std::size_t at_ = 0;
};

/// A system in a frame loop of its own, which is shown a sequence again and again.
class RepeatedRun {
public:
    RepeatedRun(const Sequence &sequence, const SystemDescription &system, WorkerPool &pool)
        : RepeatedRun(footage_of(sequence, repeated_fps), system,
                      tuned(system, own_setting(system)), pool) {}

    struct Cost {
        /// The time that a frame's estimate takes; negative where the frame was measured, or no
        /// depth could be given by a system that measures.
        double ms;
        double cpu_ms; ///< of all threads, for the whole turn of the loop; negative as `ms` is
        double measured_cpu_ms; ///< the same of a frame that was measured; else negative
    };
    Cost next() {
        const double before_ms = cpu_ms();
        const FrameResult frame = loop_.step(std::chrono::seconds(1));
        const double used_ms = cpu_ms() - before_ms;
        const bool sparse = sparse_ && frame.sequence > 0;
        if (frame.estimate.source != FrameSource::estimated && !sparse)
            return {-1, -1, frame.estimate.source == FrameSource::measured ? used_ms : -1};
        return {std::chrono::duration<double, std::milli>(frame.estimation_time).count(), used_ms,
                -1};
    }

private:
    static constexpr double repeated_fps = 30;

    RepeatedRun(Footage footage, const SystemDescription &system, const Tuned &own,
                WorkerPool &pool)
        : footage_(std::move(footage)), sparse_(!system.dense),
          loop_(footage_.rig,
                system_factory(
                    system, {.options = own.estimator, .pool = pool, .truth = footage_.truth_at()}),
                own.gate) {
        [[maybe_unused]] const Status started = loop_.start();
        assert(started); // frames in memory are always there
    }

    Footage footage_;
    bool sparse_;
    FrameLoop loop_;
};

bool is_timed(const SystemDescription &system, bool baselines) {
    if (!baselines)
        return system.name == "paper" || system.name == "default";
    return system.name != "oracle"; // which is no system
}

} // namespace

Stopwatches::Stopwatches(std::vector<std::string> names, const std::string &reference)
    : names_(std::move(names)), ms_(names_.size()), ratios_(names_.size()) {
    const auto found = std::ranges::find(names_, reference);
    assert(found != names_.end());
    reference_ = static_cast<std::size_t>(found - names_.begin());
}

void Stopwatches::add_round(const std::vector<double> &ms) {
    assert(ms.size() == names_.size());
    if (!(ms[reference_] > 0))
        return;
    for (std::size_t i = 0; i < ms.size(); ++i) {
        if (ms[i] < 0)
            continue;
        ms_[i].push_back(ms[i]);
        ratios_[i].push_back(ms[i] / ms[reference_]);
    }
}

std::vector<Timing> Stopwatches::timings() const {
    std::vector<Timing> timings;
    for (std::size_t i = 0; i < names_.size(); ++i)
        if (!ms_[i].empty())
            timings.push_back({.name = names_[i],
                               .ms = *percentile(ms_[i], 50),
                               .ratio = *percentile(ratios_[i], 50),
                               .ratio_q1 = *percentile(ratios_[i], 25),
                               .ratio_q3 = *percentile(ratios_[i], 75),
                               .rounds = static_cast<int>(ms_[i].size())});
    return timings;
}

int Stopwatches::rounds() const {
    const auto fewest = std::ranges::min_element(ms_, {}, [](const auto &m) { return m.size(); });
    return static_cast<int>(fewest->size());
}

std::vector<Timing> time_flow(const Sequence &sequence, Watch &watch) {
    cv::setNumThreads(1); // the three-step search has one, too
    const EstimatorOptions::Flow options;
    Stopwatches watches({"Three Step Search", "Lucas Kanade", "Harris Corner"},
                        "Three Step Search");
    std::vector<Match> grid, found;
    Pairs pairs(sequence);
    for (; pairs.any() && watches.rounds() < least_rounds && !Watch::stopped(); pairs.next()) {
        place_grid(options, pairs.before().measured, grid);
        const LumaView from = pairs.before().luma;
        const LumaView to = pairs.after().luma;
        found = grid;
        const double tss = time_ms([&] { find_three_step_flow(options, from, to, found); });
        found = grid;
        const double lk = time_ms([&] { find_lucas_kanade_flow(options, from, to, found); });
        const double harris =
            time_ms([&] { find_harris_corners(from, options.grid * options.grid); });
        watches.add_round({tss, lk, harris});
        watch.tick(2);
    }
    return watches.timings();
}

double stages_work() {
    return 3 * least_rounds;
}

double systems_work(bool baselines) {
    double work = 0;
    for (const SystemDescription &system : systems())
        if (is_timed(system, baselines))
            work += work_of(system);
    return least_rounds * work;
}

SystemTimes time_systems(const Sequence &sequence, bool baselines, int workers, Watch &watch) {
    constexpr int most_rounds = 4 * least_rounds;
    WorkerPool pool(workers);
    std::vector<std::string> names;
    std::vector<std::unique_ptr<RepeatedRun>> runs;
    for (const SystemDescription &system : systems()) {
        if (!is_timed(system, baselines))
            continue;
        names.emplace_back(system.name);
        runs.push_back(std::make_unique<RepeatedRun>(sequence, system, pool));
    }
    cv::setNumThreads(workers); // as many as ours have: here one system runs at a time
    Stopwatches watches(names, "paper");
    Stopwatches cpu_watches(names, "paper"), measured_watches(names, "paper");
    const auto paper = static_cast<std::size_t>(std::ranges::find(names, "paper") - names.begin());
    const double work = systems_work(baselines) / least_rounds;
    std::vector<double> ms(runs.size()), cpu_ms(runs.size()), measured_ms(runs.size());
    for (int round = 0; round < most_rounds && watches.rounds() < least_rounds; ++round) {
        for (std::size_t i = 0; i < runs.size() && !Watch::stopped(); ++i) {
            const RepeatedRun::Cost cost = runs[i]->next();
            ms[i] = cost.ms;
            cpu_ms[i] = cost.cpu_ms;
            if (i != paper)
                measured_ms[i] = cost.measured_cpu_ms;
        }
        if (Watch::stopped())
            break;
        watches.add_round(ms);
        cpu_watches.add_round(cpu_ms);
        if (cpu_ms[paper] > 0) // the last estimate: what the costs are relative to
            measured_ms[paper] = cpu_ms[paper];
        measured_watches.add_round(measured_ms);
        watch.tick(work);
    }
    cv::setNumThreads(1); // as system_factory() has it
    return {watches.timings(), cpu_watches.timings(), measured_watches.timings()};
}

std::vector<Timing> time_stages(const Sequence &sequence, int workers, Watch &watch) {
    const EstimatorOptions options = *estimator_preset("paper");
    WorkerPool pool(workers);
    ForwardReprojection reprojection(sequence.camera, pool);
    RansacPose ransac(options.ransac,
                      static_cast<std::size_t>(options.flow.grid * options.flow.grid));
    DepthMap warped(sequence.camera.width, sequence.camera.height);
    std::vector<Match> matches;
    Stopwatches watches({"flow", "pose", "reprojection", "all"}, "all");
    Pairs pairs(sequence);
    for (int tries = 0; pairs.any() && tries < 4 * least_rounds &&
                        watches.rounds() < least_rounds && !Watch::stopped();
         ++tries, pairs.next()) {
        const DepthView depth = pairs.before().measured;
        const double flow = time_ms([&] {
            place_grid(options.flow, depth, matches);
            find_three_step_flow(options.flow, pairs.before().luma, pairs.after().luma, matches);
        });
        std::optional<RansacPose::Solution> solution;
        const double pose = time_ms([&] { solution = ransac.solve(matches, sequence.camera); });
        watch.tick();
        if (!solution)
            continue;
        const double warp = time_ms([&] { reprojection.warp(depth, solution->pose, warped); });
        watches.add_round({flow, pose, warp, flow + pose + warp});
    }
    return watches.timings();
}

} // namespace afterglow
