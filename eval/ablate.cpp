// SPDX-License-Identifier: Apache-2.0
#include "eval/ablate.hpp"

#include "eval/progress.hpp"
#include "eval/scoring/evaluation.hpp"
#include "eval/scoring/summary_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <functional>
#include <iterator>
#include <optional>
#include <string_view>

namespace afterglow {

const std::vector<Variant> &ablation_variants() {
    static const std::vector<Variant> all = {
        {"default", {}, "all stages as they are"},
        {"one keyframe", {"compose.keyframes=1"}, "no earlier map is kept"},
        {"three maps a frame",
         {"compose.maps_per_frame=3"},
         "earlier maps are warped into what the last one leaves empty"},
        {"moving parts not followed",
         {"compose.follow_moving=false"},
         "parts of the picture that move have no depth"},
        {"no crack filling", {"surface.crack_px=0"}, "holes that a warp tears stay open"},
        {"edges carried",
         {"warp.least_edge_distance_px=1"},
         "readings on depth edges are carried as well"},
        {"no smoothing", {"surface.smooth_radius_px=0"}, "measured maps are carried as they came"},
        {"global shutter", {"motion.readout_s=0"}, "rows are taken to be read at one instant"},
        {"nothing learnt",
         {"self_calibration.tilt=0", "self_calibration.curvature=0", "self_calibration.lag_s=0"},
         "depth maps are taken to be exposed with their images, and to be straight"},
        {"lag alone learnt",
         {"self_calibration.tilt=0", "self_calibration.curvature=0"},
         "depth maps are taken to be straight"},
        {"no speed prior", {"motion.speed=10"}, "turn and shift are told apart by the image alone"},
        {"points independent",
         {"alignment.independent_share=1"},
         "errors of neighbouring points are taken to be independent"},
        {"coarser alignment",
         {"template.finest_level=2"},
         "aligned at a quarter of the resolution"},
        {"fewer points", {"template.points_per_level=500"}, "an eighth of the points is aligned"},
        {"edges as measured",
         {"error.edge_registration_px=0"},
         "the expected error leaves out misplaced depth edges"},
        {"no jitter of the lag",
         {"error.lag_jitter_s=0"},
         "depth maps are taken to be exposed exactly at the assumed times"},
        {"no sensor noise",
         {"sensor.floor_m=0", "sensor.linear=0", "sensor.quadratic_per_m=0"},
         "readings are taken to be all but exact"},
        {"gate: target alone",
         {"gate.measurement_price=0"},
         "measurements that would save more error than they cost are not made"},
        {"gate: coverage alone",
         {"gate.measurement_price=0", "gate.target_mre=100"},
         "the expected error lights nothing"},
        {"gate: error alone", {"gate.coverage_floor=0"}, "lost coverage lights nothing"},
        {"gate: any gain",
         {"gate.worthwhile=100"},
         "lit on a missed target even if a measurement would hardly help"},
    };
    return all;
}

namespace {

std::optional<double> change(const Metric &metric, const Summary &from, const Summary &to) {
    const auto a = metric.of(from);
    const auto b = metric.of(to);
    return a && b ? std::optional(*b - *a) : std::nullopt;
}

/// "1.37 (-0.02)"; the first row has no change.
std::string cell(const Metric &metric, const std::vector<Summary> &rows, std::size_t row) {
    const auto value = metric.of(rows[row]);
    if (!value)
        return "-";
    const auto by = row > 0 ? change(metric, rows[0], rows[row]) : std::nullopt;
    return fmt::format("{:.2f}", *value) + (by ? fmt::format(" ({:+.2f})", *by) : "");
}

std::string to_text(const std::vector<Summary> &rows) {
    std::string out = fmt::format("{}, preset {}\n{:<22}", rows[0].dataset, rows[0].preset, "");
    for (const Metric &metric : summary_metrics())
        out += fmt::format("{:>16}", metric.title);
    for (std::size_t row = 0; row < rows.size(); ++row) {
        out += fmt::format("\n{:<22}", ablation_variants()[row].name);
        for (const Metric &metric : summary_metrics())
            out += fmt::format("{:>16}", cell(metric, rows, row));
    }
    return out + "\n";
}

std::string to_markdown(const std::vector<Summary> &rows) {
    std::string out = fmt::format("**{}**\n\n| variant |", rows[0].dataset);
    for (const Metric &metric : summary_metrics())
        out += fmt::format(" {} |", metric.title);
    out += " what is lost |\n|---|";
    for (std::size_t i = 0; i < summary_metrics().size(); ++i)
        out += "---|";
    out += "---|\n";
    for (std::size_t row = 0; row < rows.size(); ++row) {
        out += fmt::format("| {} |", ablation_variants()[row].name);
        for (const Metric &metric : summary_metrics())
            out += fmt::format(" {} |", cell(metric, rows, row));
        out += fmt::format(" {} |\n", ablation_variants()[row].shows);
    }
    return out;
}

/// An object for each variant: its assignments, its summary as `run --json` gives it, and its
/// change against the first variant.
std::vector<nlohmann::json> to_objects(const std::vector<Summary> &rows) {
    std::vector<nlohmann::json> objects;
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Variant &variant = ablation_variants()[row];
        nlohmann::json &object = objects.emplace_back();
        object = {{"variant", variant.name},
                  {"assignments", variant.assignments},
                  {"summary", rows[row]}};
        for (const Metric &metric : summary_metrics())
            object["change"][std::string(metric.key)] = change(metric, rows[0], rows[row]);
    }
    return objects;
}

TuningArguments tuning_of(const AblateArguments &arguments, const Variant &variant) {
    TuningArguments tuning = arguments.tuning;
    tuning.assignments.insert(tuning.assignments.end(), variant.assignments.begin(),
                              variant.assignments.end());
    return tuning;
}

Result<Summary> score(const AblateArguments &arguments, Footage &footage, const Variant &variant,
                      const std::function<void(int done)> &progress) {
    const auto resolved = tuning_of(arguments, variant).resolve();
    if (!resolved)
        return resolved.error();
    WorkerPool pool(arguments.workers);
    const auto evaluation = evaluate(footage, pipeline_factory(resolved->first, pool),
                                     resolved->second, {.publish = {}, .progress = [&](int done) {
                                                            progress(done);
                                                            return true;
                                                        }});
    if (!evaluation)
        return evaluation.error();
    if (Status scored = check_scored(*evaluation, footage.name); !scored)
        return scored.error();
    return summarize(*evaluation, footage.name, arguments.tuning.preset,
                     resolved->second.target_mre);
}

/// A summary for each variant.
Result<std::vector<Summary>> score_all(const AblateArguments &arguments,
                                       const std::string &dataset) {
    auto footage = arguments.footage.open(dataset);
    if (!footage)
        return footage.error();
    const auto &variants = ablation_variants();
    Progress progress("", static_cast<double>(variants.size()) * footage->frames);
    std::vector<Summary> rows;
    for (const Variant &variant : variants) {
        progress.set_what(fmt::format("{}, {}", footage->name, variant.name));
        const double before = static_cast<double>(rows.size()) * footage->frames;
        auto summary =
            score(arguments, *footage, variant, [&](int done) { progress.update(before + done); });
        if (!summary)
            return summary.error();
        rows.push_back(*std::move(summary));
    }
    return rows;
}

} // namespace

void AblateArguments::add_to(CLI::App &command) {
    command
        .add_option("datasets", datasets,
                    "Folders in known layouts (docs/datasets.md), or " + synthetic_words())
        ->required();
    tuning.add_to(command);
    footage.add_to(command);
    add_workers_option(command, workers);
    auto *as_json = command.add_flag("--json", json, "Print one JSON array");
    command.add_flag("--markdown", markdown, "Print tables in Markdown")->excludes(as_json);
}

Status ablate(const AblateArguments &arguments) {
    for (const Variant &variant : ablation_variants())
        if (const auto resolved = tuning_of(arguments, variant).resolve(); !resolved)
            return Error{fmt::format("variant \"{}\": {}", variant.name, resolved.error().message),
                         EINVAL};
    std::vector<nlohmann::json> objects;
    for (const std::string &dataset : arguments.datasets) {
        const auto rows = score_all(arguments, dataset);
        if (!rows)
            return rows.error();
        if (arguments.json)
            std::ranges::move(to_objects(*rows), std::back_inserter(objects));
        else
            fmt::print("{}\n", arguments.markdown ? to_markdown(*rows) : to_text(*rows));
        std::fflush(stdout);
    }
    if (arguments.json)
        fmt::print("{}\n", json_text(objects, 1));
    return ok();
}

} // namespace afterglow
