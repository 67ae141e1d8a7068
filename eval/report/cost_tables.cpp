// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/run_system.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/table_makers.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr const char *how_timed =
    "Medians of times taken in turn, with quartiles of the ratios. Ratios within a round do not "
    "depend on other load of the machine.";

const Timing *find_timing(const std::vector<Timing> &timings, std::string_view name) {
    const auto found = std::ranges::find(timings, name, &Timing::name);
    return found == timings.end() ? nullptr : &*found;
}

std::string range_text(double low, double high, int digits) {
    return fmt::format("{:.{}f} to {:.{}f}", low, digits, high, digits);
}

} // namespace

std::optional<Table> flow_table(const Results &results) {
    Table table{.id = "table-1",
                .title = "Table I. Run times of flow and corners",
                .explanation = how_timed,
                .corner = "algorithm",
                .columns = {"relative time", "quartiles", "time (ms)", "rounds"},
                .rows = {}};
    const auto base = paper::flow_ms("Three Step Search");
    for (const Timing &t : results.flow_times) {
        const auto theirs = paper::flow_ms(t.name);
        table.rows.push_back({t.name,
                              {{text_of(t.ratio, 2), theirs ? text_of(*theirs / *base, 2) : ""},
                               {range_text(t.ratio_q1, t.ratio_q3, 2)},
                               {text_of(t.ms, 3), text_of(theirs, 0)},
                               {std::to_string(t.rounds)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

std::optional<Table> frame_rate_table(const Results &results) {
    Table table{.id = "table-5",
                .title = "Table V. Frame rates",
                .explanation = how_timed,
                .corner = "system",
                .columns = {"relative frame rate", "quartiles", "frames/s", "time (ms)", "rounds"},
                .rows = {}};
    const auto base = paper::frames_per_second("paper");
    for (const Timing &t : results.system_times) {
        const auto theirs = paper::frames_per_second(t.name);
        table.rows.push_back({title_of(t.name),
                              {{text_of(1 / t.ratio, 3), theirs ? text_of(*theirs / *base, 3) : ""},
                               {range_text(1 / t.ratio_q3, 1 / t.ratio_q1, 3)},
                               {text_of(1000 / t.ms, 1), text_of(theirs, 2)},
                               {text_of(t.ms, 2)},
                               {std::to_string(t.rounds)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

std::optional<Table> stage_time_table(const Results &results) {
    Table table{.id = "run-time",
                .title = "Where the paper's system spends its time",
                .explanation = "Pose only is flow and pose, all that tracking the camera needs. "
                               "Theirs follow from the 13 ms of Table I, the 30 frames a second of "
                               "Table V and 58 for the pose alone (Section V-A).",
                .corner = "stage",
                .columns = {"share (%)", "quartiles", "time (ms)", "rounds"},
                .rows = {}};
    const Timing *flow = find_timing(results.stage_times, "flow");
    const Timing *pose = find_timing(results.stage_times, "pose");
    if (!flow || !pose)
        return std::nullopt;
    for (const Timing &t : results.stage_times)
        if (t.name != "all")
            table.rows.push_back(
                {t.name,
                 {{text_of(100 * t.ratio, 1), text_of(paper::stage_share(t.name), 1)},
                  {range_text(100 * t.ratio_q1, 100 * t.ratio_q3, 1)},
                  {text_of(t.ms, 3)},
                  {std::to_string(t.rounds)}}});
    table.rows.push_back({"pose only",
                          {{text_of(100 * (flow->ratio + pose->ratio), 1),
                            text_of(*paper::stage_share("flow") + *paper::stage_share("pose"), 1)},
                           {},
                           {text_of(flow->ms + pose->ms, 3)},
                           {}}});
    return table;
}

std::optional<double> typical_duty_cycle(const Results &results, std::string_view system) {
    std::vector<double> values;
    for (const ScoredDataset &dataset : headline_of(datasets_of(results.scores)))
        if (const Score *score = tuned_score(results.scores, dataset.name, system))
            values.push_back(score->summary.duty_cycle);
    return percentile(values, 50);
}

std::optional<ProcessingPower> processing_power(const Results &results, std::string_view system) {
    const paper::Power &p = paper::power;
    const double busy_w = p.core_active + p.memory_active;
    const double idle_w = p.core_idle + p.memory_idle;
    if (system == "paper")
        return ProcessingPower{.lit_w = idle_w, .dark_w = busy_w};
    const Timing *dark = find_timing(results.system_cpu_times, system);
    if (!dark)
        return std::nullopt;
    // Where no frame was measured while times were taken, hardly any is.
    const Timing *measured = find_timing(results.measured_cpu_times, system);
    const Timing *lit = measured ? measured : dark;
    const auto average_w = [&](const Timing &timing) {
        return busy_w * timing.ratio + idle_w * std::max(0.0, 1 - timing.ratio);
    };
    return ProcessingPower{.lit_w = average_w(*lit), .dark_w = average_w(*dark)};
}

std::optional<Table> power_table(const Results &results) {
    const Timing *timing = find_timing(results.system_cpu_times, "default");
    if (!timing)
        return std::nullopt;
    Table table{.id = "table-6",
                .title = "Table VI. Power while estimating",
                .explanation =
                    std::string(what_is_charged) +
                    " Above 100 % afterglow could not keep up on that board, which would have "
                    "to be as much faster, at as many more watts, and never be idle.",
                .corner = "",
                .columns = {"average power of afterglow (W)", "share of This Work's CPU time (%)",
                            "quartiles", "rounds"},
                .rows = {}};
    const auto busy = [](double ratio) { return 100 * ratio; };
    const auto idle = [](double ratio) { return 100 * std::max(0.0, 1 - ratio); };
    const auto add = [&](const char *name, double watts, auto share) {
        const auto [low, high] = std::minmax({share(timing->ratio_q1), share(timing->ratio_q3)});
        table.rows.push_back({name,
                              {{text_of(watts * share(timing->ratio) / 100, 2), text_of(watts, 2)},
                               {text_of(share(timing->ratio), 1)},
                               {range_text(low, high, 1)},
                               {std::to_string(timing->rounds)}}});
    };
    const paper::Power &p = paper::power;
    add("core, active", p.core_active, busy);
    add("core, idle", p.core_idle, idle);
    add("DRAM, active", p.memory_active, busy);
    add("DRAM, idle", p.memory_idle, idle);
    add("total, active", p.core_active + p.memory_active, busy);
    add("total, idle", p.core_idle + p.memory_idle, idle);
    if (const Timing *measured = find_timing(results.measured_cpu_times, "default")) {
        const ProcessingPower power = *processing_power(results, "default");
        table.rows.push_back({"all of it, in a measured frame",
                              {{text_of(power.lit_w, 2)},
                               {text_of(busy(measured->ratio), 1)},
                               {range_text(busy(measured->ratio_q1), busy(measured->ratio_q3), 1)},
                               {std::to_string(measured->rounds)}}});
    }
    return table;
}

std::optional<Table> saving_table(const Results &results) {
    Table table{.id = "power",
                .title = "Power saved, of the TOF camera's own (%)",
                .explanation = "",
                .corner = "TOF camera (W)",
                .columns = {},
                .rows = {}};
    std::vector<std::pair<double, ProcessingPower>> charged;
    for (const char *name : {"paper", "default"}) {
        const auto duty_cycle = typical_duty_cycle(results, name);
        const auto power = processing_power(results, name);
        if (!duty_cycle || !power)
            continue;
        table.columns.push_back(fmt::format("{}, {:.1f} % lit", title_of(name), *duty_cycle));
        charged.emplace_back(*duty_cycle, *power);
    }
    if (charged.empty())
        return std::nullopt;
    table.explanation =
        std::string("Eq. 9 with each system's median duty cycle in Table III. ") + what_is_charged;
    for (int watts = 1; watts <= 5; ++watts) {
        Table::Row row{std::to_string(watts), {}};
        for (const auto &[duty_cycle, power] : charged)
            row.cells.push_back(
                {text_of(100 * (1 - power.system_w(duty_cycle, watts) / watts), 1)});
        if (typical_duty_cycle(results, "paper") && (watts == 1 || watts == 5))
            row.cells[0].theirs =
                text_of(watts == 1 ? paper::smallest_saving : paper::largest_saving, 0);
        table.rows.push_back(std::move(row));
    }
    return table;
}

} // namespace afterglow
