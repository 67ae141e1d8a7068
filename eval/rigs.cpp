// SPDX-License-Identifier: Apache-2.0
#include "eval/rigs.hpp"

#include "core/base/write_file.hpp"
#include "core/pipeline.hpp"
#include "eval/json.hpp"
#include "eval/progress.hpp"
#include "eval/rigs/rig_footage.hpp"
#include "eval/rigs/rig_sweep.hpp"
#include "eval/scoring/evaluation.hpp"
#include "eval/scoring/summary.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

namespace afterglow {
namespace {

using Tuning = std::pair<EstimatorOptions, GatePolicy>;

SyntheticOptions room(const RigsArguments &arguments) {
    SyntheticOptions options;
    options.frames = arguments.frames;
    options.seed = arguments.seed;
    options.motion = arguments.motion;
    return options;
}

Result<Summary> summary_of(const Result<Evaluation> &evaluation, const RigsArguments &arguments,
                           const Tuning &tuning) {
    if (!evaluation)
        return evaluation.error();
    if (Status scored = check_scored(*evaluation, synthetic_name); !scored)
        return scored.error();
    return summarize(*evaluation, synthetic_name, arguments.tuning.preset,
                     tuning.second.target_mre);
}

Result<Summary> score_registered(const RigsArguments &arguments, const Tuning &tuning,
                                 WorkerPool &pool) {
    auto footage = open_synthetic_footage(room(arguments));
    if (!footage)
        return footage.error();
    return summary_of(evaluate(*footage, pipeline_factory(tuning.first, pool), tuning.second),
                      arguments, tuning);
}

/// Its coverage is that of what the TOF camera can see.
Result<Summary> score(const SweptRig &rig, const RigsArguments &arguments, const Tuning &tuning,
                      WorkerPool &pool, const std::function<void(int done)> &progress) {
    const auto truth = std::make_shared<RigTruth>(room(arguments), rig.geometry());
    auto footage = open_rig_footage(room(arguments), rig.geometry(), truth);
    if (!footage)
        return footage.error();
    std::vector<double> coverage;
    EvaluationHooks hooks;
    hooks.publish = [&](std::uint64_t index, const Estimate &estimate) {
        // No frame is dropped where nothing is in real time: its number is that of its image.
        if (estimate.source == FrameSource::estimated)
            if (const auto share = truth->coverage(index, estimate.depth))
                coverage.push_back(*share);
        return ok();
    };
    hooks.progress = [&](int done) {
        progress(done);
        return true;
    };
    auto summary =
        summary_of(evaluate(*footage, pipeline_factory(tuning.first, pool), tuning.second, hooks),
                   arguments, tuning);
    if (summary)
        summary->coverage_median = percentile(coverage, 50);
    return summary;
}

nlohmann::json to_json(const SweptRig &rig, const Summary &summary, const Summary &reference) {
    return {{"tof", rig.tof.name},
            {"color", rig.color.name},
            {"baseline_mm", rig.baseline_mm},
            {"published", rig.published},
            {"duty_cycle", summary.duty_cycle},
            {"mre_median", summary.mre_median},
            {"mre_p95", summary.mre_p95},
            {"coverage_median", summary.coverage_median},
            {"ms_per_frame_median", summary.ms_per_frame_median},
            {"reference_mre_median", reference.mre_median}};
}

void print_row(const std::string &name, const Summary &s, const Summary &reference) {
    const auto number = [](const std::optional<double> &value, int digits) {
        return value ? fmt::format("{:.{}f}", *value, digits) : "-";
    };
    const auto ratio = s.mre_median && reference.mre_median
                           ? std::optional(*s.mre_median / *reference.mre_median)
                           : std::nullopt;
    fmt::print("{:<32}{:>8.1f}{:>9}{:>9}{:>11}{:>8}{:>8}\n", name, s.duty_cycle,
               number(s.mre_median, 2), number(s.mre_p95, 2), number(ratio, 2),
               number(s.coverage_median, 1), number(s.ms_per_frame_median, 1));
    std::fflush(stdout);
}

} // namespace

void RigsArguments::add_to(CLI::App &command) {
    command
        .add_option("--only", only,
                    "Rigs with these words alone, as a list: of each kind that is named one of "
                    "those named")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(sweep_words()));
    tuning.add_to(command);
    command.add_option("--frames", frames, "Of each rig")
        ->check(CLI::Range(3, 1000000))
        ->capture_default_str();
    command.add_option("--seed", seed, "Of the room and the motion")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{4294967295}));
    command.add_option("--motion", motion, "Speed of the cameras, relative; 0 = still")
        ->check(number_between(0, 100));
    add_workers_option(command, workers);
    command.add_option("--json", json, "Write an array with an object for each rig to this file");
}

Status rigs(const RigsArguments &arguments) {
    const auto tuning = arguments.tuning.resolve();
    if (!tuning)
        return tuning.error();
    if (tuning->first.method == Method::paper)
        return Error{fmt::format("--preset {}: it needs depth that is registered to the images, "
                                 "which these rigs do not give",
                                 arguments.tuning.preset),
                     EINVAL};
    std::optional<OutputFile> json; // before the work, so that it is not in vain
    if (!arguments.json.empty()) {
        Result<OutputFile> opened = OutputFile::open(arguments.json);
        if (!opened)
            return opened.error();
        json.emplace(*std::move(opened));
    }
    WorkerPool pool(arguments.workers);
    const auto reference = score_registered(arguments, *tuning, pool);
    if (!reference)
        return reference.error();
    fmt::print("{:<32}{:>8}{:>9}{:>9}{:>11}{:>8}{:>8}\n", "TOF, colour, baseline, published",
               "lit %", "MRE med", "MRE p95", "x registered", "cov.med", "ms");
    print_row("registered 640x480", *reference, *reference);

    const std::vector<SweptRig> all = select_rigs(arguments.only);
    Progress progress("", static_cast<double>(all.size()) * arguments.frames);
    nlohmann::json rows = nlohmann::json::array();
    for (const SweptRig &rig : all) {
        const std::string name = fmt::format("{}", fmt::join(rig.words(), " "));
        progress.set_what(name);
        const auto summary = score(rig, arguments, *tuning, pool, [&](int done) {
            progress.update(static_cast<double>(rows.size()) * arguments.frames + done);
        });
        if (!summary)
            return Error{fmt::format("{}: {}", name, summary.error().message),
                         summary.error().code};
        print_row(name, *summary, *reference);
        rows.push_back(to_json(rig, *summary, *reference));
    }
    return json ? std::move(*json).write(json_text(rows, 2) + "\n") : ok();
}

} // namespace afterglow
