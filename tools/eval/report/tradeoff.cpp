// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/tradeoff.hpp"

#include "core/estimator_options.hpp"
#include "tools/eval/report/paper_figures.hpp"
#include "tools/eval/report/play.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <thread>

namespace afterglow {
namespace {

struct Game {
    const SystemDescription *system;
    Setting setting;
    std::optional<Score> score{};
};

const std::vector<double> thresholds = {0.5, 1, 2, 4, 8, 16, 32, 64};
const std::vector<double> targets = {0.4, 0.6, 0.8, 1, 1.3, 1.7, 2.5, 4};
const std::vector<double> oracle_targets = {0.5, 1, 1.5};
const std::vector<double> intervals = {2, 3, 4, 6, 10, 20};
const std::vector<double> slow_intervals = {4};

bool is_ablation(const SystemDescription &system) {
    return system.name == "reverse-warp" || system.name == "median";
}

/// These take a tenth of a second and more for a frame.
bool is_slow(const SystemDescription &system) {
    return system.name == "copy" || system.name == "opencv-rgbd";
}

void add(std::vector<Game> &games, const SystemDescription &system, const char *knob,
         const std::vector<double> &values) {
    for (const double value : values)
        games.push_back({&system, {knob, value}});
}

/// Those that decide themselves when to measure, and those that never do.
std::vector<Game> first_games(Sweep how) {
    std::vector<Game> games;
    for (const SystemDescription &system : lineup()) {
        if (how == Sweep::adaptive && system.name != "paper" && system.name != "default")
            continue;
        if (system.lighting == Lighting::never)
            games.push_back({&system, {}});
        else if (is_ablation(system))
            add(games, system, "threshold", {EstimatorOptions().ransac.threshold});
        else if (system.name == "default")
            add(games, system, "target", targets);
        else if (system.name == "oracle")
            add(games, system, "target", oracle_targets);
        else if (system.lighting == Lighting::adaptive)
            add(games, system, "threshold", thresholds);
    }
    // The longest first, so that the threads end together.
    std::ranges::stable_sort(
        games, [](const Game &a, const Game &b) { return a.system->dense < b.system->dense; });
    return games;
}

/// Those with a fixed interval, among them the one that gives `duty_cycle`, percent.
std::vector<Game> second_games(Sweep how, double duty_cycle) {
    std::vector<Game> games;
    for (const SystemDescription &system : lineup()) {
        if (how == Sweep::adaptive || system.lighting != Lighting::interval)
            continue;
        std::vector<double> values;
        if (how == Sweep::full)
            values = is_slow(system) ? slow_intervals : intervals;
        if (duty_cycle > 0)
            values.push_back(std::max(2.0, std::round(100 / duty_cycle)));
        std::ranges::sort(values);
        values.erase(std::unique(values.begin(), values.end()), values.end());
        add(games, system, "interval", values);
    }
    return games;
}

void play_all(std::vector<Game> &games, const Sequence &sequence, int workers, const Watch &watch) {
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        WorkerPool alone(1);
        for (std::size_t i = next++; i < games.size(); i = next++) {
            Game &game = games[i];
            const auto played = play(sequence, *game.system, game.setting, alone, watch);
            if (played)
                game.score = Score{game.setting,
                                   summarize(*played, sequence.name, std::string(game.system->name),
                                             game.setting.name == "target" ? game.setting.value
                                                                           : paper::aimed_mre),
                                   sequence.layout};
        }
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < workers; ++i)
        threads.emplace_back(work);
    work();
    for (std::thread &thread : threads)
        thread.join();
}

} // namespace

void sweep(const Sequence &sequence, Sweep how, int workers,
           const std::function<void(Score)> &on_score) {
    const int frames = static_cast<int>(sequence.frames.size());
    const Watch watch(sequence.name, sweep_frames(how, frames));
    std::vector<Score> scores;
    const auto run = [&](std::vector<Game> games) {
        play_all(games, sequence, workers, watch);
        for (Game &game : games) {
            if (!game.score)
                continue;
            scores.push_back(*game.score);
            on_score(*std::move(game.score));
        }
    };
    run(first_games(how));
    run(second_games(how, compared_duty_cycle(scores, sequence.name)));
}

int sweep_frames(Sweep how, int frames) {
    return frames * static_cast<int>(first_games(how).size() + second_games(how, 50).size());
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

/// The score that `distance` is least of; the earlier, where it is the same.
template <class Distance>
const Score *nearest(const std::vector<const Score *> &scores, Distance distance) {
    const auto best = std::ranges::min_element(scores, {}, distance);
    return best == scores.end() ? nullptr : *best;
}

} // namespace

const Score *tuned_score(std::span<const Score> scores, std::string_view dataset,
                         std::string_view system) {
    return nearest(scores_of(scores, dataset, system), [](const Score *score) {
        return std::abs(*score->summary.mre_median - paper::aimed_mre);
    });
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
    return nearest(scores_of(scores, dataset, system), [&](const Score *score) {
        return std::abs(score->summary.duty_cycle - duty_cycle);
    });
}

const Score *plain_score(std::span<const Score> scores, std::string_view dataset,
                         std::string_view system) {
    for (const Score *score : scores_of(scores, dataset, system))
        if (score->setting.value == EstimatorOptions().ransac.threshold)
            return score;
    return nullptr;
}

} // namespace afterglow
