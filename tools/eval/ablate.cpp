// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/ablate.hpp"

#include "tools/eval/evaluation.hpp"
#include "tools/eval/json.hpp"
#include "tools/eval/progress.hpp"
#include "tools/eval/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <optional>
#include <string_view>

namespace afterglow {
namespace {

struct Variant {
    std::string_view name;
    std::vector<std::string> assignments;
    std::string_view shows; ///< what is lost, in the words of docs/estimation.md
};

/// The first is what the others are compared with.
const std::vector<Variant> &variants() {
    static const std::vector<Variant> all = {
        {"default", {}, "all stages as they are"},
        {"one keyframe", {"compose.keyframes=1"}, "no earlier map is kept"},
        {"one map a frame",
         {"compose.maps_per_frame=1"},
         "earlier maps are aligned with, but not warped into the view"},
        {"any earlier map",
         {"compose.most_disagreement=100"},
         "earlier maps are used even where they contradict the reference"},
        {"no crack filling", {"warp.crack_px=0"}, "holes that a warp tears stay open"},
        {"edges carried",
         {"warp.least_edge_distance_px=1"},
         "readings on depth edges are carried as well"},
        {"no smoothing", {"surface.smooth_radius_px=0"}, "measured maps are carried as they came"},
        {"global shutter", {"motion.readout_s=0"}, "rows are taken to be read at one instant"},
        {"nothing learnt",
         {"calibration.tilt=0", "calibration.curvature=0", "calibration.lag_s=0"},
         "depth maps are taken to be exposed with their images, and to be straight"},
        {"lag alone learnt",
         {"calibration.tilt=0", "calibration.curvature=0"},
         "depth maps are taken to be straight"},
        {"no speed prior", {"motion.speed=10"}, "turn and shift are told apart by the image alone"},
        {"points independent",
         {"alignment.independent_share=1"},
         "errors of neighbouring points are taken to be independent"},
        {"coarser alignment", {"texture.finest_level=2"}, "aligned at a quarter of the resolution"},
        {"fewer points", {"texture.points_per_level=500"}, "an eighth of the points is aligned"},
        {"edges as measured",
         {"error.edge_registration_px=0"},
         "the expected error leaves out misplaced depth edges"},
        {"no calibration error",
         {"error.calibration=0"},
         "the expected error leaves out lens and calibration"},
        {"no sensor noise",
         {"sensor.floor_m=0", "sensor.linear=0", "sensor.quadratic_per_m=0"},
         "readings are taken to be all but exact"},
        {"gate: coverage alone", {"gate.target_mre=100"}, "the expected error lights nothing"},
        {"gate: error alone", {"gate.coverage_floor=0"}, "lost coverage lights nothing"},
        {"gate: any gain",
         {"gate.worthwhile=100"},
         "lit on a missed target even if a measurement would hardly help"},
    };
    return all;
}

/// A column of the table: a figure of merit, and how it is printed.
struct Column {
    std::string_view key;
    std::string_view title;
    std::optional<double> (*of)(const Summary &);
};

constexpr Column columns[] = {
    {"duty_cycle", "duty %", [](const Summary &s) { return std::optional(s.duty_cycle); }},
    {"mre_median", "MRE med", [](const Summary &s) { return s.mre_median; }},
    {"mre_p95", "MRE p95", [](const Summary &s) { return s.mre_p95; }},
    {"coverage_median", "cov. med", [](const Summary &s) { return s.coverage_median; }},
    {"coverage_p5", "cov. p5", [](const Summary &s) { return s.coverage_p5; }},
};

std::optional<double> change(const Column &column, const Summary &from, const Summary &to) {
    const auto a = column.of(from);
    const auto b = column.of(to);
    return a && b ? std::optional(*b - *a) : std::nullopt;
}

/// "1.37 (-0.02)"; the first row has no change.
std::string cell(const Column &column, const std::vector<Summary> &rows, std::size_t row) {
    const auto value = column.of(rows[row]);
    if (!value)
        return "-";
    const auto by = row > 0 ? change(column, rows[0], rows[row]) : std::nullopt;
    return fmt::format("{:.2f}", *value) + (by ? fmt::format(" ({:+.2f})", *by) : "");
}

std::string to_text(const std::vector<Summary> &rows) {
    std::string out = fmt::format("{}, preset {}\n{:<22}", rows[0].dataset, rows[0].preset, "");
    for (const Column &column : columns)
        out += fmt::format("{:>16}", column.title);
    for (std::size_t row = 0; row < rows.size(); ++row) {
        out += fmt::format("\n{:<22}", variants()[row].name);
        for (const Column &column : columns)
            out += fmt::format("{:>16}", cell(column, rows, row));
    }
    return out + "\n";
}

std::string to_markdown(const std::vector<Summary> &rows) {
    std::string out = fmt::format("**{}**\n\n| variant |", rows[0].dataset);
    for (const Column &column : columns)
        out += fmt::format(" {} |", column.title);
    out += " what is lost |\n|---|";
    for (std::size_t i = 0; i < std::size(columns); ++i)
        out += "---|";
    out += "---|\n";
    for (std::size_t row = 0; row < rows.size(); ++row) {
        out += fmt::format("| {} |", variants()[row].name);
        for (const Column &column : columns)
            out += fmt::format(" {} |", cell(column, rows, row));
        out += fmt::format(" {} |\n", variants()[row].shows);
    }
    return out;
}

/// Objects of the variant, its assignments, its summary as `run --json` gives it, and its change
/// against the first variant.
std::vector<std::string> to_json(const std::vector<Summary> &rows) {
    std::vector<std::string> objects;
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const Variant &variant = variants()[row];
        std::vector<std::string> assignments;
        for (const std::string &assignment : variant.assignments)
            assignments.push_back(json_string(assignment));
        std::vector<std::string> changes;
        for (const Column &column : columns)
            changes.push_back(fmt::format("\"{}\": {}", column.key,
                                          json_number(change(column, rows[0], rows[row]))));
        objects.push_back(
            json_object({{"variant", json_string(std::string(variant.name))},
                         {"assignments", json_array(assignments)},
                         {"summary", to_json(rows[row])},
                         {"change", fmt::format("{{{}}}", fmt::join(changes, ", "))}}));
    }
    return objects;
}

Result<Summary> score(const AblateArguments &arguments, const std::string &dataset,
                      const Variant &variant) {
    TuningArguments tuning = arguments.tuning;
    tuning.assignments.insert(tuning.assignments.end(), variant.assignments.begin(),
                              variant.assignments.end());
    const auto resolved = tuning.resolve();
    if (!resolved)
        return resolved.error();
    auto footage = arguments.footage.open(dataset);
    if (!footage)
        return footage.error();
    Progress progress(fmt::format("{}, {}", footage->name, variant.name), footage->frames);
    const auto evaluation =
        evaluate(*footage, {.estimator = resolved->first,
                            .gate = resolved->second,
                            .workers = arguments.workers,
                            .publish = {},
                            .progress = [&](int done) { progress.update(done); }});
    if (!evaluation)
        return evaluation.error();
    if (evaluation->frames.empty())
        return Error{fmt::format("{}: not one usable frame", dataset)};
    return summarize(*evaluation, footage->name, tuning.preset, resolved->second.target_mre);
}

} // namespace

void AblateArguments::add_to(CLI::App &command) {
    command.add_option("datasets", datasets, "Folders in TUM layout, or the word synthetic")
        ->required();
    tuning.add_to(command);
    footage.add_to(command);
    command
        .add_option("--workers", workers, "Threads that share the work; no result depends on it")
        ->check(CLI::Range(1, 64));
    auto *as_json = command.add_flag("--json", json, "Print one JSON array");
    command.add_flag("--markdown", markdown, "Print tables in Markdown")->excludes(as_json);
}

Status ablate(const AblateArguments &arguments) {
    std::vector<std::string> objects;
    for (const std::string &dataset : arguments.datasets) {
        std::vector<Summary> rows;
        for (const Variant &variant : variants()) {
            auto summary = score(arguments, dataset, variant);
            if (!summary)
                return summary.error();
            rows.push_back(*std::move(summary));
        }
        if (arguments.json)
            std::ranges::move(to_json(rows), std::back_inserter(objects));
        else
            fmt::print("{}\n", arguments.markdown ? to_markdown(rows) : to_text(rows));
        std::fflush(stdout);
    }
    if (arguments.json)
        fmt::print("{}\n", json_array(objects));
    return ok();
}

} // namespace afterglow
