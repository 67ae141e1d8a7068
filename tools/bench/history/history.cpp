// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/history/history.hpp"

#include "core/base/read_file.hpp"
#include "tools/picture/figure.hpp"
#include "tools/picture/html_text.hpp"
#include "tools/picture/page_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace afterglow::bench {
namespace {

using nlohmann::json;

/// What the time of a frame is compared with, and that of a warp: in one run, so that the machine
/// does not matter.
constexpr const char *frame_reference = "opencv/lk144+reproject";
constexpr const char *warp_name = "warp", *warp_reference = "limit/memcpy";

/// Values by the place of their file among those of its kind, 1, 2, ...
using Points = std::vector<std::pair<double, double>>;

/// One of the numbers of instructions that afterglow-count tells of a run.
struct Count {
    const char *key;  ///< in its JSON
    const char *name; ///< on the page
    double aim;       ///< of preset default on a Cortex-A7, millions
};
constexpr Count counts[] = {{"instructions_mean", "mean", 14},
                            {"instructions_max", "worst frame", 60},
                            {"instructions_still", "still", 3}};

struct History {
    std::vector<std::string> time_files, count_files;
    std::map<std::string, Points> frame_shares; ///< time by benchmark / that of frame_reference
    Points warp_ratios;                         ///< time of a warp / that of warp_reference
    /// Millions of instructions by run (sequence, preset and target) and by place in `counts`.
    std::map<std::string, std::map<int, Points>> millions;
    std::map<std::string, bool> has_aims; ///< by run
};

/// Empty where there is no text.
std::string text_of(const json &object, const char *key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// NaN where there is no number.
double number_of(const json &object, const char *key) {
    const auto found = object.find(key);
    const double number =
        found != object.end() && found->is_number() ? found->get<double>() : std::nan("");
    return number >= 1e-30 && number <= 1e30 ? number : std::nan(""); // as far as axes have ticks
}

/// A benchmark of afterglow, not of what it is compared with.
bool is_own(std::string_view benchmark) {
    return !benchmark.starts_with("opencv/") && !benchmark.starts_with("limit/");
}

/// Median CPU time of each benchmark, us; the only one, if it was not repeated.
Result<std::map<std::string, double>> times_of(const std::string &file, const json &benchmarks) {
    std::map<std::string, double> times, medians;
    for (const json &entry : benchmarks) {
        const std::string name = text_of(entry, "run_name");
        const double time = number_of(entry, "cpu_time");
        if (name.empty() || !(time > 0) || text_of(entry, "time_unit") != "us")
            return Error{file + " has a benchmark without name or time in us", EINVAL};
        (text_of(entry, "aggregate_name") == "median" ? medians : times)[name] = time;
    }
    medians.merge(times);
    if (!medians.contains(frame_reference))
        return Error{fmt::format("{} has no {} to compare with", file, frame_reference), EINVAL};
    if (std::ranges::none_of(medians, is_own, [](const auto &entry) { return entry.first; }))
        return Error{file + " has no benchmark of afterglow", EINVAL};
    return medians;
}

Status add_times(const std::string &file, const json &benchmarks, History &history) {
    const auto times = times_of(file, benchmarks);
    if (!times)
        return times.error();
    history.time_files.push_back(file);
    const auto place = static_cast<double>(history.time_files.size());
    for (const auto &[name, time] : *times)
        if (is_own(name))
            history.frame_shares[name].emplace_back(place, time / times->at(frame_reference));
    const auto warp = times->find(warp_name), copy = times->find(warp_reference);
    if (warp != times->end() && copy != times->end())
        history.warp_ratios.emplace_back(place, warp->second / copy->second);
    return ok();
}

Status add_counts(const std::string &file, const json &runs, History &history) {
    if (runs.empty())
        return Error{file + " has no counts", EINVAL};
    history.count_files.push_back(file);
    const auto place = static_cast<double>(history.count_files.size());
    for (const json &run : runs) {
        const std::string sequence = text_of(run, "sequence"), preset = text_of(run, "preset"),
                          target = text_of(run, "target");
        if (sequence.empty() || preset.empty() || target.empty())
            return Error{file + " has a count without sequence, preset or target", EINVAL};
        const std::string name = fmt::format("{}, {}, {}", sequence, preset, target);
        for (int i = 0; const Count &count : counts) {
            const double value = number_of(run, count.key);
            if (!(value > 0))
                return Error{fmt::format("{} has no {} of {}", file, count.key, name), EINVAL};
            history.millions[name][i++].emplace_back(place, value / 1e6);
        }
        history.has_aims[name] = preset == "default" && target == "armv7";
    }
    return ok();
}

Status add(const std::string &file, History &history) {
    const auto text = read_file(file);
    if (!text)
        return text.error();
    const json content = json::parse(*text, nullptr, false);
    if (content.is_object() && content.contains("benchmarks") && content["benchmarks"].is_array())
        return add_times(file, content["benchmarks"], history);
    if (content.is_array())
        return add_counts(file, content, history);
    return Error{file + " is neither what ./dev bench --json nor ./dev bench arm --json writes",
                 EINVAL};
}

/// A plot over the files whose y axis has room for all points; there is one at least, and all are
/// above 0.
Plot plot_of(std::string title, std::string label, std::size_t files,
             std::vector<Plot::Series> series) {
    double least = 1e300, most = 0;
    for (const Plot::Series &one : series)
        for (const auto &[place, value] : one.points) {
            least = std::min(least, value);
            most = std::max(most, value);
        }
    // To 1, 2 or 5 times a power of ten.
    const auto rounded_down = [](double value) {
        const double power = std::pow(10, std::floor(std::log10(value)));
        return power * (value >= 5 * power ? 5 : value >= 2 * power ? 2 : 1);
    };
    return {.title = std::move(title),
            .x = {.label = "file",
                  .min = 0,
                  .max = static_cast<double>(files) + 1,
                  .logarithmic = false,
                  .whole = true},
            .y = {.label = std::move(label),
                  .min = rounded_down(least),
                  .max = 1 / rounded_down(1 / most),
                  .logarithmic = true},
            .series = std::move(series)};
}

Plot::Series aim(std::string name, int color, double value, std::size_t files) {
    return {.name = std::move(name),
            .color = color,
            .marks = false,
            .dashed = true,
            .points = {{0, value}, {static_cast<double>(files) + 1, value}}};
}

Figure time_figure(const History &history) {
    const std::size_t files = history.time_files.size();
    Figure figure{.id = "times",
                  .title = "Times",
                  .explanation = fmt::format("CPU time of one thread, median of the repetitions, "
                                             "divided by that of {}, and of {}, in the same file.",
                                             frame_reference, warp_reference)};
    std::vector<Plot::Series> series;
    for (int color = 0; const auto &[name, points] : history.frame_shares) {
        series.push_back({.name = name, .color = color % plot_colors, .points = points});
        if (name == "frame/default")
            series.push_back(aim("aim of frame/default", color % plot_colors, 0.2, files));
        ++color;
    }
    figure.panels.push_back(plot_of(fmt::format("Beside {}", frame_reference),
                                    "share of its time, log scale", files, std::move(series)));
    if (!history.warp_ratios.empty())
        figure.panels.push_back(plot_of(
            fmt::format("Beside {}", warp_reference), "multiple of its time, log scale", files,
            {{.name = warp_name, .color = 4, .points = history.warp_ratios},
             aim("aim of warp", 4, 3, files)}));
    return figure;
}

Figure count_figure(const History &history) {
    const std::size_t files = history.count_files.size();
    Figure figure{.id = "instructions",
                  .title = "Instructions",
                  .explanation = "Millions of instructions for a frame, counted by an emulator."};
    for (const auto &[run, of_run] : history.millions) {
        std::vector<Plot::Series> series;
        for (const auto &[i, points] : of_run) {
            series.push_back({.name = counts[i].name, .color = i, .points = points});
            if (history.has_aims.at(run))
                series.push_back(
                    aim(fmt::format("aim of {}", counts[i].name), i, counts[i].aim, files));
        }
        figure.panels.push_back(plot_of(run, "millions, log scale", files, std::move(series)));
    }
    return figure;
}

/// A figure and the names of its files.
std::string section(const Figure &figure, const std::vector<std::string> &files) {
    std::string out = html_figure(figure) + "<ol>\n";
    for (const std::string &file : files)
        out += fmt::format("<li>{}</li>\n",
                           html_text(std::filesystem::path(file).filename().string()));
    return out + "</ol>\n";
}

} // namespace

Result<std::string> history_page(const std::vector<std::string> &files) {
    History history;
    for (const std::string &file : files)
        if (const Status added = add(file, history); !added)
            return added.error();
    std::string page = "<!doctype html>\n<html lang=en><head><meta charset=utf-8>\n"
                       "<meta name=viewport content=\"width=device-width, initial-scale=1\">\n"
                       "<title>afterglow: speed</title>\n<style>";
    page += page_style;
    page += "</style></head>\n<body>\n<h1>afterglow: speed over time</h1>\n";
    if (!history.time_files.empty())
        page += section(time_figure(history), history.time_files);
    if (!history.count_files.empty())
        page += section(count_figure(history), history.count_files);
    return page + "</body></html>\n";
}

} // namespace afterglow::bench
