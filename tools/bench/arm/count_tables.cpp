// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/arm/count_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace afterglow::bench {
namespace {

constexpr double million = 1e6;
/// What tells one count from others.
constexpr const char *identity[] = {"sequence", "preset", "target", "frames"};
constexpr const char *keys[] = {"instructions_mean", "instructions_max", "instructions_still"};

using OfFrame = std::function<std::uint64_t(const FrameCount &)>;

double mean(const std::vector<FrameCount> &frames, const OfFrame &value) {
    double sum = 0;
    for (const FrameCount &frame : frames)
        sum += static_cast<double>(value(frame));
    return frames.empty() ? 0 : sum / static_cast<double>(frames.size());
}

const FrameCount &worst(const std::vector<FrameCount> &frames) {
    return *std::ranges::max_element(frames, {}, &FrameCount::sum);
}

} // namespace

nlohmann::json summary_of(const CountedSequence &counted) {
    const auto &[stages, frames, still] = counted.counts;
    return {{"sequence", counted.sequence},
            {"preset", counted.preset},
            {"target", counted.target},
            {"frames", frames.size()},
            {"instructions_mean", std::llround(mean(frames, &FrameCount::sum))},
            {"instructions_max", worst(frames).sum()},
            {"instructions_still", std::llround(mean(still, &FrameCount::sum))}};
}

std::string summary_head() {
    return fmt::format("Millions of instructions\n{:<20} {:<8} {:<8} {:>6} {:>8} {:>8} {:>8} {:>9} "
                       "{:>14}\n",
                       "sequence", "preset", "target", "frames", "mean", "worst", "still", "track",
                       "measure");
}

std::string summary_line(const CountedSequence &counted) {
    const auto &[stages, frames, still] = counted.counts;
    const auto measured = std::ranges::count_if(frames, [](auto &f) { return f.measure > 0; });
    const double measure = mean(frames, [](auto &f) { return f.measure; }) *
                           static_cast<double>(frames.size()) /
                           static_cast<double>(std::max<std::ptrdiff_t>(measured, 1));
    return fmt::format(
        "{:<20} {:<8} {:<8} {:>6} {:>8.2f} {:>8.2f} {:>8.2f} {:>9.2f} {:>8.2f} ({})\n",
        counted.sequence, counted.preset, counted.target, frames.size(),
        mean(frames, &FrameCount::sum) / million,
        static_cast<double>(worst(frames).sum()) / million, mean(still, &FrameCount::sum) / million,
        mean(frames, [](auto &f) { return f.track; }) / million, measure / million, measured);
}

std::string stage_table(const CountedSequence &counted) {
    const auto &[stages, frames, still] = counted.counts;
    const auto of_stage = [](std::size_t i) {
        return [i](const FrameCount &frame) { return frame.stages.at(i); };
    };
    std::vector<std::size_t> order(stages.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, std::greater(),
                      [&](std::size_t i) { return mean(counted.counts.frames, of_stage(i)); });
    const double all = mean(frames, &FrameCount::sum);
    std::string text = fmt::format(
        "\n{}, {}, {}: {:>{}} {:>7} {:>8} {:>8}\n", counted.sequence, counted.preset,
        counted.target, "mean",
        std::max<int>(40 - static_cast<int>(counted.sequence.size() + counted.preset.size() +
                                            counted.target.size()),
                      4),
        "share", "worst", "still");
    for (const std::size_t i : order) {
        const double instructions = mean(frames, of_stage(i));
        if (instructions >= 0.01 * all)
            text += fmt::format("    {:<34} {:>8.2f} {:>5.1f} % {:>8.2f} {:>8.2f}\n", stages[i],
                                instructions / million, 100 * instructions / all,
                                static_cast<double>(worst(frames).stages.at(i)) / million,
                                mean(still, of_stage(i)) / million);
    }
    return text;
}

std::string regressions(const nlohmann::json &summaries, const nlohmann::json &baseline,
                        double margin) {
    std::string text;
    for (const nlohmann::json &now : summaries) {
        const auto before = std::ranges::find_if(baseline, [&](const nlohmann::json &entry) {
            return entry.is_object() &&
                   std::ranges::all_of(keys,
                                       [&](const char *key) {
                                           return entry.contains(key) && entry.at(key).is_number();
                                       }) &&
                   std::ranges::all_of(identity, [&](const char *key) {
                       return entry.contains(key) && entry.at(key) == now.at(key);
                   });
        });
        const std::string name =
            fmt::format("{}, {}, {}", now["sequence"].get<std::string>(),
                        now["preset"].get<std::string>(), now["target"].get<std::string>());
        if (before == baseline.end()) {
            text += name + ": there is nothing to compare with\n";
            continue;
        }
        for (const char *key : keys) {
            const auto [is, was] = std::pair(now[key].get<double>(), (*before)[key].get<double>());
            if (is > was * (1 + margin / 100))
                text += fmt::format("{}: {} was {:.2f} million and is {:.2f}\n", name, key,
                                    was / million, is / million);
        }
    }
    return text;
}

} // namespace afterglow::bench
