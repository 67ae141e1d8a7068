// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/paper_figures.hpp"
#include "tools/eval/report/play.hpp"
#include "tools/eval/report/table_makers.hpp"
#include "tools/eval/report/tradeoff.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace afterglow {
namespace {

constexpr const char *how_timed =
    "Medians of times taken in turn, with quartiles of the ratios: the machine does not matter, "
    "only how they compare.";

const Timing *find_timing(const std::vector<Timing> &timings, std::string_view name) {
    const auto found = std::ranges::find(timings, name, &Timing::name);
    return found == timings.end() ? nullptr : &*found;
}

std::string range_text(double low, double high, int digits) {
    return fmt::format("{:.{}f} to {:.{}f}", low, digits, high, digits);
}

} // namespace

std::string text_of(const std::optional<double> &value, int digits) {
    return value ? fmt::format("{:.{}f}", *value, digits) : "";
}

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

std::optional<Table> ransac_table(const Results &results) {
    Table table{.id = "table-2",
                .title = "Table II. What RANSAC is worth",
                .explanation = "Error of the translation over simulated motions, a fifth of the "
                               "depths, the flow or both corrupted.",
                .corner = "corrupted",
                .columns = {"reduction (%)", "RMSE without (mm)", "RMSE with (mm)"},
                .rows = {}};
    for (const RansacScore &score : results.ransac) {
        const char *name = score.depth && score.flow ? "depth and flow"
                           : score.depth             ? "depth"
                                                     : "flow";
        table.rows.push_back({name,
                              {{text_of(score.reduction(), 1),
                                text_of(paper::ransac_reduction(score.depth, score.flow), 1)},
                               {text_of(1000 * score.plain_rmse_m, 2)},
                               {text_of(1000 * score.ransac_rmse_m, 2)}}});
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

std::optional<Table> stage_table(const Results &results) {
    Table table{.id = "run-time",
                .title = "Where the paper's system spends its time",
                .explanation = "Pose only is flow and pose, all that tracking the camera needs. "
                               "Theirs follow from its 30 and 58 frames a second.",
                .corner = "stage",
                .columns = {"share (%)", "quartiles", "time (ms)"},
                .rows = {}};
    const double pose_share = 100 * *paper::frames_per_second("paper") / paper::pose_only_fps;
    const Timing *flow = find_timing(results.stage_times, "flow");
    const Timing *pose = find_timing(results.stage_times, "pose");
    for (const Timing &t : results.stage_times)
        if (t.name != "all")
            table.rows.push_back({t.name,
                                  {{text_of(100 * t.ratio, 1),
                                    t.name == "reprojection" ? text_of(100 - pose_share, 1) : ""},
                                   {range_text(100 * t.ratio_q1, 100 * t.ratio_q3, 1)},
                                   {text_of(t.ms, 3)}}});
    if (!flow || !pose)
        return std::nullopt;
    table.rows.push_back({"pose only",
                          {{text_of(100 * (flow->ratio + pose->ratio), 1), text_of(pose_share, 1)},
                           {},
                           {text_of(flow->ms + pose->ms, 3)}}});
    return table;
}

std::optional<double> typical_duty_cycle(const Results &results, std::string_view system) {
    std::vector<double> values;
    for (const std::string &dataset : datasets_of(results.scores))
        if (const Score *score = tuned_score(results.scores, dataset, system))
            values.push_back(score->summary.duty_cycle);
    return percentile(values, 50);
}

std::optional<PowerModel> power_model_of(const Results &results, std::string_view system) {
    const Timing *timing = find_timing(results.system_times, system);
    if (!timing)
        return std::nullopt;
    const auto shrunk = [&](double active, double idle) {
        return idle + (active - idle) * timing->ratio;
    };
    PowerModel model;
    model.compute_w = shrunk(paper::power.core_active, paper::power.core_idle);
    model.memory_w = shrunk(paper::power.memory_active, paper::power.memory_idle);
    return model;
}

std::optional<Table> power_table(const Results &results) {
    const Timing *timing = find_timing(results.system_times, "default");
    const auto model = power_model_of(results, "default");
    if (!timing || !model)
        return std::nullopt;
    const paper::Power &p = paper::power;
    Table table{
        .id = "table-6",
        .title = "Table VI. Power while estimating",
        .explanation =
            "The paper's watts are of its board, which This Work keeps busy for the whole "
            "of a frame. Ours are not measured with a meter: they are the same watts for "
            "the share of This Work's time that afterglow is measured to take (Table V), "
            "and idle for the rest. A share above 100 % could not keep up on that board; its "
            "watts are then those of a faster one of the same kind.",
        .corner = "",
        .columns = {"This Work (W)", "afterglow: share of the time (%)", "afterglow: average (W)"},
        .rows = {}};
    const std::string busy = text_of(100 * timing->ratio, 1);
    const std::string idle = text_of(100 * std::max(0.0, 1 - timing->ratio), 1);
    const auto add = [&](const char *name, double watts, const std::string &share,
                         const std::string &average) {
        table.rows.push_back({name, {{"", text_of(watts, 2)}, {share, ""}, {average, ""}}});
    };
    add("core, active", p.core_active, busy, text_of(model->compute_w, 2));
    add("core, idle", p.core_idle, idle, "");
    add("DRAM, active", p.memory_active, busy, text_of(model->memory_w, 2));
    add("DRAM, idle", p.memory_idle, idle, "");
    add("total, active", p.core_active + p.memory_active, busy,
        text_of(model->compute_w + model->memory_w, 2));
    add("total, idle", p.core_idle + p.memory_idle, idle, "");
    return table;
}

std::optional<Table> saving_table(const Results &results) {
    Table table{.id = "power",
                .title = "Power saved, of the TOF camera's own",
                .explanation = "",
                .corner = "TOF camera (W)",
                .columns = {},
                .rows = {}};
    std::vector<std::pair<double, PowerModel>> models;
    for (const char *name : {"paper", "default"}) {
        const auto duty_cycle = typical_duty_cycle(results, name);
        if (!duty_cycle)
            continue;
        const std::string title = fmt::format("{}, {:.1f} % lit", title_of(name), *duty_cycle);
        table.columns.push_back(title + ": saved (%)");
        models.emplace_back(*duty_cycle / 100, PowerModel{});
        const auto scaled = power_model_of(results, name);
        if (std::string_view(name) == "paper" || !scaled)
            continue;
        table.columns.push_back(title + ", idle when done: saved (%)");
        models.emplace_back(*duty_cycle / 100, *scaled);
    }
    if (models.empty())
        return std::nullopt;
    table.explanation = "Eq. 9 with the paper's measured board and each system's median duty cycle "
                        "in Table III; last, with afterglow's own share of the time (Table VI).";
    for (int watts = 1; watts <= 5; ++watts) {
        Table::Row row{std::to_string(watts), {}};
        for (auto [duty_cycle, model] : models) {
            model.tof_w = watts;
            row.cells.push_back({text_of(100 * model.saving(duty_cycle), 1)});
        }
        if (typical_duty_cycle(results, "paper") && (watts == 1 || watts == 5))
            row.cells[0].theirs =
                text_of(watts == 1 ? paper::smallest_saving : paper::largest_saving, 0);
        table.rows.push_back(std::move(row));
    }
    return table;
}

std::optional<Table> infill_table(const Results &results) {
    Table table{
        .id = "infill",
        .title = "Infilling",
        .explanation = "A fifth of a measured map is taken away, the furthest (out of "
                       "range) or the nearest (saturation), and given back from the map "
                       "ten frames before. Overlap is the paper's figure; ours can also "
                       "score what was filled.",
        .corner = "",
        .columns = {"overlap MRE (%)", "filled: MRE (%)", "filled (% of the missing)", "trials"},
        .rows = {}};
    for (const InfillScore &score : results.infill) {
        const double theirs =
            score.reason == "saturation" ? paper::saturation_mre : paper::out_of_range_mre;
        table.rows.push_back(
            {fmt::format("{}, {}, {}", score.dataset, score.reason, title_of(score.system)),
             {{text_of(score.overlap_mre, 2), score.system == "paper" ? text_of(theirs, 2) : ""},
              {text_of(score.filled_mre, 2)},
              {text_of(score.filled, 1)},
              {std::to_string(score.trials)}}});
    }
    return table.rows.empty() ? std::nullopt : std::optional(table);
}

std::vector<Table> make_tables(const Results &results) {
    std::vector<Table> tables;
    const auto add = [&](std::optional<Table> table) {
        if (table)
            tables.push_back(*std::move(table));
    };
    add(evaluation_table(results));
    for (Table &table : comparison_tables(results))
        tables.push_back(std::move(table));
    add(ablation_table(results));
    add(flow_table(results));
    add(frame_rate_table(results));
    add(stage_table(results));
    add(power_table(results));
    add(saving_table(results));
    add(ransac_table(results));
    add(infill_table(results));
    return tables;
}

} // namespace afterglow
