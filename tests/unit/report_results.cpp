// SPDX-License-Identifier: Apache-2.0
#include "core/gate.hpp"
#include "eval/experiments/png_data.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/figures.hpp"
#include "eval/report/html.hpp"
#include "eval/report/paper_figures.hpp"
#include "eval/report/results_json.hpp"
#include "eval/report/table.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

#include <functional>
#include <string>
#include <vector>

using namespace afterglow;

namespace {

Score score(const char *dataset, const char *system, const char *knob, double value,
            double duty_cycle, double mre) {
    Score s;
    s.setting = {knob, value};
    s.summary.dataset = dataset;
    s.summary.preset = system;
    s.summary.frames = 100;
    s.summary.duty_cycle = duty_cycle;
    s.summary.measured_share = duty_cycle - 1;
    s.summary.mre_median = mre;
    s.summary.mre_mean = mre;
    s.summary.mae_cm_median = 2 * mre;
    s.summary.rmse_cm_median = 3 * mre;
    s.summary.coverage_median = 90;
    return s;
}

/// Something of everything.
Results sample() {
    Results r;
    r.scores = {score("desk", "paper", "threshold", 4, 20, 1.5),
                score("desk", "paper", "threshold", 2, 40, 1.1),
                score("desk", "default", "target", 1, 12, 0.9),
                score("desk", "default", "target", 3, 6, 2.2), // not the default
                score("desk", "copy", "interval", 8, 12.5, 3.3),
                score("desk", "reverse-warp", "threshold", 4, 20, 1.8),
                score("desk", "median", "threshold", 4, 20, 1.6),
                score("desk", "default", "target", GatePolicy().target_mre, 9, 1.3)};
    r.flow_times = {{"Three Step Search", 1.25, 1, 1, 1, 30},
                    {"Lucas Kanade", 5.5, 4.4, 4.2, 4.6, 30}};
    r.system_times = {{"paper", 7, 1, 1, 1, 30}, {"default", 2.8, 0.4, 0.38, 0.42, 30}};
    r.system_cpu_times = {{"paper", 7, 1, 1, 1, 30}, {"default", 2.8, 0.4, 0.38, 0.42, 30}};
    r.measured_cpu_times = {{"default", 7, 1, 0.9, 1.1, 5}};
    r.scores[7].calibration = {{1, 2}, {1.5, 4}};
    r.stage_times = {{"flow", 2, 0.25, 0.2, 0.3, 30},
                     {"pose", 1, 0.125, 0.1, 0.15, 30},
                     {"reprojection", 5, 0.625, 0.6, 0.7, 30},
                     {"all", 8, 1, 1, 1, 30}};
    r.ransac = {{.depth = true, .flow = false, .plain_rmse_m = 0.02, .ransac_rmse_m = 0.005}};
    r.ablations = {{"default", "nothing", r.scores[2].summary},
                   {"no crack filling", "holes stay open", r.scores[3].summary}};
    InfillScore filled;
    filled.dataset = "desk";
    filled.system = "paper";
    filled.reason = "saturation";
    filled.trials = 9;
    filled.overlap_mre = 0.77;
    filled.filled_mre = 1.23;
    filled.filled = 87.5;
    r.infill = {filled};
    r.pictures = {{"desk", "an image", png_data(Image<Rgb>(4, 3, {1, 2, 3}))}};
    return r;
}

std::string all_tables(const Results &results) {
    std::string out;
    for (const Table &table : make_tables(results))
        out += to_csv(table) + to_text(table);
    return out;
}

} // namespace

TEST_CASE("a changed result changes the report's page, tables and JSON", "[report]") {
    const Results before = sample();
    const std::vector<std::pair<const char *, std::function<void(Results &)>>> changes = {
        {"MRE", [](Results &r) { r.scores[2].summary.mre_median = 0.87; }},
        {"MAE", [](Results &r) { r.scores[2].summary.mae_cm_median = 7.77; }},
        {"RMSE", [](Results &r) { r.scores[2].summary.rmse_cm_median = 7.77; }},
        {"duty cycle", [](Results &r) { r.scores[2].summary.duty_cycle = 13.7; }},
        {"measured share", [](Results &r) { r.scores[7].summary.measured_share = 7.7; }},
        {"coverage", [](Results &r) { r.scores[2].summary.coverage_median = 77.7; }},
        {"setting", [](Results &r) { r.scores[2].setting.value = 1.375; }},
        {"copy's MRE", [](Results &r) { r.scores[4].summary.mre_median = 3.77; }},
        {"reverse warp", [](Results &r) { r.scores[5].summary.mre_median = 2.77; }},
        {"median filter", [](Results &r) { r.scores[6].summary.mre_median = 2.77; }},
        {"holes", [](Results &r) { r.scores[6].summary.coverage_median = 97; }},
        {"flow time", [](Results &r) { r.flow_times[1].ms = 7.777; }},
        {"flow ratio", [](Results &r) { r.flow_times[1].ratio = 7.77; }},
        {"lower quartile", [](Results &r) { r.flow_times[1].ratio_q1 = 3.77; }},
        {"upper quartile", [](Results &r) { r.flow_times[1].ratio_q3 = 7.77; }},
        {"rounds", [](Results &r) { r.flow_times[1].rounds = 77; }},
        {"system time", [](Results &r) { r.system_times[1].ms = 7.77; }},
        {"system ratio", [](Results &r) { r.system_times[1].ratio = 0.777; }},
        {"CPU time", [](Results &r) { r.system_cpu_times[1].ratio = 0.777; }},
        {"CPU time of a measured frame", [](Results &r) { r.measured_cpu_times[0].ratio = 1.777; }},
        {"true over expected", [](Results &r) { r.scores[7].summary.true_over_expected = 1.77; }},
        {"misjudged", [](Results &r) { r.scores[7].summary.misjudged_share = 17.7; }},
        {"stage share", [](Results &r) { r.stage_times[0].ratio = 0.177; }},
        {"stage time", [](Results &r) { r.stage_times[0].ms = 7.77; }},
        {"plain RMSE", [](Results &r) { r.ransac[0].plain_rmse_m = 0.0777; }},
        {"RANSAC's RMSE", [](Results &r) { r.ransac[0].ransac_rmse_m = 0.0077; }},
        {"frames", [](Results &r) { r.scores[7].summary.frames = 77; }},
        {"95th percentile", [](Results &r) { r.scores[7].summary.mre_p95 = 7.77; }},
        {"worst coverage", [](Results &r) { r.scores[7].summary.coverage_p5 = 77.7; }},
        {"correlation", [](Results &r) { r.scores[7].summary.expected_correlation = 0.777; }},
        {"ablation's duty cycle", [](Results &r) { r.ablations[1].summary.duty_cycle = 77; }},
        {"ablation's MRE", [](Results &r) { r.ablations[1].summary.mre_median = 7.77; }},
        {"ablation's MRE tail", [](Results &r) { r.ablations[1].summary.mre_p95 = 7.77; }},
        {"ablation's coverage", [](Results &r) { r.ablations[1].summary.coverage_median = 7; }},
        {"ablation's worst", [](Results &r) { r.ablations[1].summary.coverage_p5 = 7.77; }},
        {"what everything is compared with",
         [](Results &r) { r.ablations[0].summary.mre_median = 7; }},
        {"overlap", [](Results &r) { r.infill[0].overlap_mre = 7.77; }},
        {"filled MRE", [](Results &r) { r.infill[0].filled_mre = 7.77; }},
        {"filled", [](Results &r) { r.infill[0].filled = 77.7; }},
        {"trials", [](Results &r) { r.infill[0].trials = 77; }},
    };
    for (const auto &[what, change] : changes) {
        INFO(what);
        Results after = sample();
        change(after);
        CHECK(to_html(before) != to_html(after));
        CHECK(all_tables(before) != all_tables(after));
        CHECK(to_json(before) != to_json(after));
    }
    Results repainted = sample();
    repainted.pictures[0].png = png_data(Image<Rgb>(4, 3, {200, 0, 0}));
    CHECK(to_html(before) != to_html(repainted));
}

TEST_CASE("a report without results shows none of our figures", "[report]") {
    CHECK(make_tables({}).empty());
    CHECK(make_figures({}).empty());
    CHECK(to_html({}).find("<table") == std::string::npos);
}

TEST_CASE("the report's page marks the paper's numbers and partial results", "[report]") {
    Results results = sample();
    CHECK(to_html(results).find("on its data\">30</span>") == std::string::npos);
    CHECK(to_html(results).find("on its data\">30.00</span>") != std::string::npos);
    CHECK(to_html(results).find("is partial") == std::string::npos);
    results.complete = false;
    CHECK(to_html(results).find("is partial") != std::string::npos);
}

TEST_CASE("the report's page needs no other file", "[report]") {
    const std::string page = to_html(sample());
    CHECK(page.find("<svg") != std::string::npos);
    CHECK(page.find("src=\"data:image/png;base64,iVBOR") != std::string::npos);
    CHECK(page.find("prefers-color-scheme: dark") != std::string::npos);
    CHECK(page.find("http") == std::string::npos);
    CHECK(page.find("<script") == std::string::npos);
}

TEST_CASE("folder names are escaped in the report's page and tables", "[report]") {
    Results results = sample();
    for (Score &s : results.scores)
        s.summary.dataset = "=<script>\"&,";
    CHECK(to_html(results).find("<script>") == std::string::npos);
    CHECK(to_html(results).find("=&lt;script&gt;&quot;&amp;,") != std::string::npos);
    CHECK(to_csv(results.scores).find("\"'=<script>\"\"&,\",paper,threshold,4") !=
          std::string::npos);
    CHECK(all_tables(sample()).find(",+20.0") != std::string::npos); // numbers stay numbers
}

TEST_CASE("the report tunes thresholds for one percent error and baselines for equal duty cycle",
          "[report]") {
    const Results r = sample();
    CHECK(tuned_score(r.scores, "desk", "paper")->setting.value == 2);
    CHECK(tuned_score(r.scores, "desk", "default")->setting.value == 1);
    CHECK(compared_duty_cycle(r.scores, "desk") == 12);
    CHECK(matched_score(r.scores, "desk", "paper")->setting.value == 4);
    CHECK(matched_score(r.scores, "desk", "sfm-sift") == nullptr);
    CHECK(compared_duty_cycle(r.scores, "kitchen") < 0);
}

TEST_CASE("the report chooses no threshold for a system that always measures", "[report]") {
    const std::vector<Score> scores = {score("desk", "paper", "threshold", 1, 100, 1)};
    CHECK(tuned_score(scores, "desk", "paper") == nullptr);
}

TEST_CASE("the paper's datasets are known by layout and by name", "[report]") {
    CHECK(paper::family_of("rgbd_dataset_freiburg1_xyz", "tum-original") == "tum");
    CHECK(paper::family_of("tum_fr1_rpy", "tum") == "tum");
    CHECK(paper::family_of("kitchen", "tum").empty());
    CHECK(paper::family_of("kitchen_0001", "nyu-v2") == "nyu");
    CHECK(paper::family_of("synthetic:icl-nuim", "") == "icl");
    CHECK(paper::family_of("bicycles", "tum").empty());
    CHECK(paper::family_of("stuma", "7-scenes").empty());
    CHECK(paper::errors("tum", "paper")->duty_cycle == 16.0);
    CHECK_FALSE(paper::errors("tum", "lk")->duty_cycle);
    CHECK_FALSE(paper::errors("tum", "sfm-orb"));
}

TEST_CASE("the report lists the paper's datasets first, with their substitutes", "[report]") {
    Results results;
    for (const char *name : {"office", "synthetic:icl-nuim", "tum_fr1_rpy"})
        for (const char *system : {"paper", "lk", "default"})
            results.scores.push_back(score(name, system, "threshold", 4, 20, 1));
    const auto tables = make_tables(results);
    const auto table = std::ranges::find(tables, "table-3", &Table::id);
    REQUIRE(table != tables.end());
    std::vector<std::string> labels;
    for (const Table::Row &row : table->rows)
        labels.push_back(row.label);
    CHECK(labels == std::vector<std::string>{"TU Munich RGB-D: tum_fr1_rpy",
                                             "ICL-NUIM (synthetic stand-in)", "office", "mean of 2",
                                             "median of 2", "median of clips and rooms"});
    CHECK(table->rows[0].cells[0].theirs == "0.96");
    CHECK(table->rows[2].cells[0].theirs.empty());
    CHECK(table->rows[3].cells[0].theirs == "0.93");
}

TEST_CASE("a merged report has the times of one file, with its version, machine and date",
          "[report]") {
    const TemporaryFolder folder;
    const auto file = [&](const char *machine, const std::vector<Timing> &flow,
                          const std::vector<Timing> &stages) {
        Results results;
        results.version = std::string("v ") + machine;
        results.machine = machine;
        results.date = std::string("day of ") + machine;
        results.flow_times = flow;
        results.stage_times = stages;
        return folder.write(machine, to_json(results));
    };
    const std::vector<Timing> slow = {{"Lucas Kanade", 9, 1, 1, 1, 30}};
    const std::vector<Timing> quick = {{"Lucas Kanade", 2, 1, 1, 1, 30}};
    const std::vector<Timing> stages = {{"all", 8, 1, 1, 1, 30}};
    Results merged;
    for (const std::string &path :
         {file("none", {}, {}), file("slow", slow, {}), file("quick", quick, stages)})
        REQUIRE(read_results(path, merged));
    CHECK(merged.machine == "slow");
    CHECK(merged.version == "v slow");
    CHECK(merged.date == "day of slow");
    REQUIRE(merged.flow_times.size() == 1);
    CHECK(merged.flow_times[0].ms == 9);
    CHECK(merged.stage_times.empty());
}

TEST_CASE("a merged system name cannot leave the report's folder", "[report]") {
    Results results;
    results.scores = {score("desk", "../../etc/passwd", "", 0, 20, 1)};
    for (const Table &table : make_tables(results))
        CHECK(table.id.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") ==
              std::string::npos);
}

TEST_CASE("the report's idle power is never negative", "[report]") {
    Results results = sample();
    const auto idle = [&] {
        for (const Table &table : make_tables(results))
            if (table.id == "table-6")
                return table.rows[1].cells[0].ours;
        return std::string();
    };
    CHECK(idle() == "0.10"); // 0.16 W for 60 % of the time
    results.system_cpu_times[1].ratio = 3.5;
    CHECK(idle() == "0.00");
}

TEST_CASE("base64 pads incomplete groups", "[report]") {
    CHECK(base64("") == "");
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("\xff\xfe") == "//4=");
}

TEST_CASE("a plot draws points beyond its axes hollow at the edge", "[report]") {
    Plot plot{.title = "p", .x = {.label = "x"}, .y = {.label = "y"}, .series = {}};
    plot.series.push_back({.name = "s", .line = false, .points = {{0.5, 0.5}}});
    CHECK(to_svg(plot).find("outside") == std::string::npos);
    plot.series[0].points = {{0.5, 7}};
    CHECK(to_svg(plot).find("outside") != std::string::npos);
}

TEST_CASE("on a logarithmic axis equal ratios are equally far apart", "[report]") {
    Plot plot{.title = "p",
              .x = {.label = "x", .min = 0.5, .max = 60, .logarithmic = true},
              .y = {.label = "y"},
              .series = {}};
    plot.series.push_back(
        {.name = "s", .line = false, .points = {{1, 0.5}, {5, 0.5}, {25, 0.5}, {0, 0.5}}});
    const std::string svg = to_svg(plot);
    std::vector<double> places;
    for (std::size_t at = svg.find("cx=\""); at != svg.npos; at = svg.find("cx=\"", at + 1))
        places.push_back(std::stod(svg.substr(at + 4)));
    REQUIRE(places.size() == 4); // by x: 0 is drawn at the left edge
    CHECK(places[0] < places[1]);
    CHECK(places[2] - places[1] == Approx(places[3] - places[2]).margin(0.2));
    for (const char *tick : {">0.5<", ">1<", ">2<", ">5<", ">10<", ">20<", ">50<"})
        CHECK(svg.find(tick) != std::string::npos);
}

TEST_CASE("a depth picture in the page has a colour bar in metres, an image none", "[report]") {
    Results results = sample();
    CHECK(to_html(results).find("class=bar") == std::string::npos);
    Picture &picture = results.pictures[0];
    picture.colors = Picture::Colors::depth;
    picture.from = 0.84;
    picture.to = 3.17;
    CHECK(to_html(results).find("<span>0.8 m</span><i class=depth></i><span>3.2 m</span>") !=
          std::string::npos);
    picture.colors = Picture::Colors::error;
    picture.from = 0;
    picture.to = 5;
    CHECK(to_html(results).find("<span>0 %</span><i class=error></i><span>5 %</span>") !=
          std::string::npos);
}

TEST_CASE("the summary compares untuned systems in each sequence, and their medians", "[report]") {
    Results results;
    const double own = GatePolicy().target_mre;
    results.scores = {score("desk", "default", "target", own, 9, 1.3),
                      score("hall", "default", "target", own, 3, 0.7),
                      score("desk", "paper", "threshold", 4, 20, 1.5),
                      score("desk", "default", "target", 1, 50, 0.4), // tuned
                      score("desk", "copy", "interval", 8, 12.5, 3.3)};
    const auto tables = make_tables(results);
    REQUIRE(tables.front().id == "summary");
    const Table &table = tables.front();
    CHECK(table.explanation.find("afterglow: lit 6.00 %, measured 5.00 %, median error 1.00 %") !=
          std::string::npos);
    std::vector<std::pair<std::string, std::string>> rows;
    for (const Table::Row &row : table.rows) {
        REQUIRE(row.cells.size() == table.columns.size());
        rows.emplace_back(row.label, row.cells[1].ours);
    }
    CHECK(rows == std::vector<std::pair<std::string, std::string>>{{"desk", "9.00"},
                                                                   {"desk", "20.00"},
                                                                   {"hall", "3.00"},
                                                                   {"median of 2", "6.00"},
                                                                   {"median of 1", "20.00"}});
    const std::string page = to_html(results);
    CHECK(page.find("<th rowspan=2>desk</th>") != std::string::npos);
    CHECK(page.find("id=\"summary\"") < page.find("id=\"tradeoff\""));
}

TEST_CASE("the report's headline leaves out short clips and synthetic rooms", "[report]") {
    Results results;
    const double own = GatePolicy().target_mre;
    results.scores = {score("desk", "default", "target", own, 9, 1.3),
                      score("clip", "default", "target", own, 90, 9),
                      score("synthetic", "default", "target", own, 1, 0.1),
                      score("synthetic-office", "default", "target", own, 9, 1.2)};
    results.scores[1].summary.frames = 29;
    const auto tables = make_tables(results);
    const auto labels = [&](const char *id) {
        const auto table = std::ranges::find(tables, id, &Table::id);
        REQUIRE(table != tables.end());
        std::vector<std::string> all;
        for (const Table::Row &row : table->rows)
            all.push_back(row.label);
        return all;
    };
    CHECK(labels("summary") == std::vector<std::string>{"desk", "synthetic-office", "median of 2"});
    CHECK(labels("summary-others") == std::vector<std::string>{"clip", "synthetic"});
    CHECK(tables.front().explanation.find("lit 9.00 %") != std::string::npos);
}

TEST_CASE("figures at duty cycles more than a quarter apart say so and are in no mean",
          "[report]") {
    Results results;
    results.scores = {score("desk", "default", "target", 1, 12, 0.9),
                      score("desk", "paper", "threshold", 4, 14, 1.5),
                      score("desk", "lk", "threshold", 4, 40, 2.5)};
    const auto tables = make_tables(results);
    const auto table = std::ranges::find(tables, "table-4-mre", &Table::id);
    REQUIRE(table != tables.end());
    REQUIRE(table->columns.size() == 3); // paper, lk, default
    CHECK(table->rows[0].cells[0].ours == "1.50");
    CHECK(table->rows[0].cells[1].ours == "2.50 [40.0/12.0 %]");
    REQUIRE(table->rows[1].label == "mean of 1");
    CHECK(table->rows[1].cells[0].ours == "1.50");
    CHECK(table->rows[1].cells[1].ours.empty());
}

TEST_CASE("the report plots each frame's expected error against its true one", "[report]") {
    const Results results = sample();
    const auto figures = make_figures(results);
    const auto figure = std::ranges::find(figures, "calibration-plots", &Figure::id);
    REQUIRE(figure != figures.end());
    REQUIRE(figure->panels.size() == 1);
    const auto &series = figure->panels[0].series;
    REQUIRE(series.size() == 3); // 1:1, 1.5:1, the frames
    CHECK(series[2].points == std::vector<std::pair<double, double>>{{1, 1.5}, {2, 4}});
}

TEST_CASE("every table and figure of power says what is charged", "[report]") {
    const Results results = sample();
    int found = 0;
    const auto check = [&](const std::string &id, const std::string &explanation) {
        if (id != "table-6" && id != "power" && id != "system-power")
            return;
        ++found;
        CHECK(explanation.find("the CPU time measured here") != std::string::npos);
    };
    for (const Table &table : make_tables(results))
        check(table.id, table.explanation);
    for (const Figure &figure : make_figures(results))
        check(figure.id, figure.explanation);
    CHECK(found == 3);
}

TEST_CASE("the page says which version made it, when, and on which processor", "[report]") {
    Results results = sample();
    CHECK(to_html(results).find("run times on") == std::string::npos);
    results.version = "1.2.3";
    results.machine = "4 x <Cortex>";
    results.date = "2026-02-03 04:05 UTC";
    CHECK(to_html(results).find("afterglow 1.2.3, 2026-02-03 04:05 UTC; run times on 4 x "
                                "&lt;Cortex&gt;.") != std::string::npos);
}
