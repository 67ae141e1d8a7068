// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/tradeoff.hpp"

#include "eval/experiments/jobs.hpp"
#include "eval/experiments/run_system.hpp"
#include "eval/report/paper_figures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

namespace afterglow {
namespace {

/// A system with a setting; and its score, once it is known.
struct Run {
    const SystemDescription *system;
    Setting setting;
    std::optional<Score> score{};
};

// own_setting() is among them in any case.
const std::vector<double> thresholds = {0.5, 1, 2, 4, 8, 16, 32, 64};
const std::vector<double> targets = {0.4, 0.6, 0.8, 1, 1.6, 2.5, 4};
const std::vector<double> oracle_targets = {0.5, 1};
const std::vector<double> intervals = {2, 3, 4, 6, 10, 20};
const std::vector<double> slow_intervals = {4, 12};

bool is_ablation(const SystemDescription &system) {
    return system.name == "reverse-warp" || system.name == "median";
}

std::vector<double> setting_values(const SystemDescription &system) {
    if (is_ablation(system))
        return {};
    if (system.name == "default")
        return targets;
    if (system.name == "oracle")
        return oracle_targets;
    if (system.lighting == Lighting::interval)
        return work_of(system) > 1 ? slow_intervals : intervals;
    return thresholds;
}

/// Adds a run for each value; equal values give one run.
void add(std::vector<Run> &runs, const SystemDescription &system, const std::string &setting,
         std::vector<double> values) {
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    for (const double value : values)
        runs.push_back({&system, {setting, value}});
}

/// Systems that decide themselves when to measure, with several settings; and those that never do.
std::vector<Run> first_runs(Sweep how) {
    std::vector<Run> runs;
    for (const SystemDescription &system : systems()) {
        if (how == Sweep::adaptive && system.name != "paper" && system.name != "default")
            continue;
        if (system.lighting == Lighting::never)
            runs.push_back({&system, {}});
        if (system.lighting != Lighting::adaptive)
            continue;
        const Setting own = own_setting(system);
        std::vector<double> values = setting_values(system);
        values.push_back(own.value);
        add(runs, system, own.name, std::move(values));
    }
    // The longest first, so that the threads end together.
    std::ranges::stable_sort(runs, std::greater{},
                             [](const Run &run) { return work_of(*run.system); });
    return runs;
}

/// Systems that measure at a fixed interval; one run of each is at `duty_cycle`, percent.
std::vector<Run> second_runs(Sweep how, double duty_cycle) {
    std::vector<Run> runs;
    for (const SystemDescription &system : systems()) {
        if (how == Sweep::adaptive || system.lighting != Lighting::interval)
            continue;
        std::vector<double> values;
        if (how == Sweep::full)
            values = setting_values(system);
        if (duty_cycle > 0)
            values.push_back(std::max(2.0, std::round(100 / duty_cycle)));
        add(runs, system, "interval", std::move(values));
    }
    return runs;
}

Score score_of(const Evaluation &evaluation, const Run &run, const Sequence &sequence) {
    const double target = run.setting.name == "target" ? run.setting.value : paper::aimed_mre;
    Score score{run.setting,
                summarize(evaluation, sequence.name, std::string(run.system->name), target),
                sequence.layout};
    if (run.system->name == "default" && run.setting.value == own_setting(*run.system).value)
        score.calibration = expected_against_true(evaluation);
    return score;
}

void run_all(std::vector<Run> &runs, const Sequence &sequence, int workers, Watch &watch) {
    run_jobs(runs.size(), workers, [&](std::size_t i) {
        Run &run = runs[i];
        WorkerPool alone(1);
        const Tuned made = tuned(*run.system, run.setting);
        if (const auto evaluation = run_system(sequence, *run.system, made, alone, watch))
            run.score = score_of(*evaluation, run, sequence);
    });
}

} // namespace

void sweep(const Sequence &sequence, Sweep how, int workers, Watch &watch,
           const std::function<void(Score)> &on_score) {
    std::vector<Score> scores;
    const auto score = [&](std::vector<Run> runs) {
        run_all(runs, sequence, workers, watch);
        for (Run &run : runs) {
            if (!run.score)
                continue;
            scores.push_back(*run.score);
            on_score(*std::move(run.score));
        }
    };
    score(first_runs(how));
    score(second_runs(how, compared_duty_cycle(scores, sequence.name)));
}

double sweep_work(Sweep how) {
    double work = 0;
    for (const auto &runs : {first_runs(how), second_runs(how, 50)})
        for (const Run &run : runs)
            work += work_of(*run.system);
    return work;
}

std::vector<const Score *> scores_of(std::span<const Score> scores, std::string_view dataset,
                                     std::string_view system) {
    std::vector<const Score *> found;
    for (const Score &score : scores)
        if (score.summary.dataset == dataset && score.summary.preset == system &&
            score.summary.mre_median && score.summary.duty_cycle < 100)
            found.push_back(&score);
    return found;
}

namespace {

/// The score of which `distance` is least; the earlier, where it is the same.
template <class Distance>
const Score *nearest(const std::vector<const Score *> &scores, Distance distance) {
    const auto best = std::ranges::min_element(scores, {}, distance);
    return best == scores.end() ? nullptr : *best;
}

} // namespace

const Score *tuned_score(std::span<const Score> scores, std::string_view dataset,
                         std::string_view system) {
    const auto all = scores_of(scores, dataset, system);
    std::vector<const Score *> good;
    std::ranges::copy_if(all, std::back_inserter(good), [](const Score *score) {
        return *score->summary.mre_median <= paper::about_aimed_mre;
    });
    if (!good.empty())
        return nearest(good, [](const Score *score) { return score->summary.duty_cycle; });
    return nearest(
        all, [](const Score *score) { return *score->summary.mre_median - paper::aimed_mre; });
}

bool is_near(double duty_cycle, double other) {
    return std::abs(duty_cycle - other) <= 0.25 * std::min(duty_cycle, other);
}

double compared_duty_cycle(std::span<const Score> scores, std::string_view dataset) {
    for (const char *reference : {"default", "paper"})
        if (const Score *score = tuned_score(scores, dataset, reference))
            return score->summary.duty_cycle;
    return -1;
}

const Score *matched_score(std::span<const Score> scores, std::string_view dataset,
                           std::string_view system) {
    const double duty_cycle = compared_duty_cycle(scores, dataset);
    if (duty_cycle < 0)
        return nullptr;
    return nearest(scores_of(scores, dataset, system), [&](const Score *score) {
        return std::abs(score->summary.duty_cycle - duty_cycle);
    });
}

const Score *preset_score(std::span<const Score> scores, std::string_view dataset,
                          std::string_view system) {
    const SystemDescription *known = find_system(system);
    if (!known)
        return nullptr;
    const Setting own = own_setting(*known);
    for (const Score &score : scores)
        if (score.summary.dataset == dataset && score.summary.preset == system &&
            score.setting.name == own.name && score.setting.value == own.value)
            return &score;
    return nullptr;
}

} // namespace afterglow
