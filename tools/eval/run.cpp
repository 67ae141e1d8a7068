// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/run.hpp"

#include "config/estimator_parameters.hpp"
#include "tools/eval/dump.hpp"
#include "tools/eval/evaluation.hpp"
#include "tools/eval/footage.hpp"
#include "tools/eval/progress.hpp"
#include "tools/eval/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

namespace afterglow {
namespace {

constexpr const char *synthetic_name = "synthetic";
constexpr int synthetic_frames = 300;

Result<Footage> open_footage(const RunArguments &arguments) {
    if (arguments.dataset == synthetic_name && !std::filesystem::exists(arguments.dataset)) {
        SyntheticOptions options;
        options.seed = arguments.seed;
        options.wake_latency_frames = arguments.wake_latency;
        options.frames = arguments.frames > 0 ? arguments.frames : synthetic_frames;
        options.noise = arguments.noise;
        options.motion = arguments.motion;
        return open_synthetic_footage(options);
    }
    return open_recorded_footage(arguments.dataset, arguments.frames, arguments.wake_latency);
}

} // namespace

void TuningArguments::add_to(CLI::App &command) {
    command.add_option("--preset", preset, "Composition of the estimator")->capture_default_str();
    command.add_option("--set", assignments, "Override a parameter: key=value; may be repeated")
        ->allow_extra_args(false);
}

Result<std::pair<EstimatorOptions, GatePolicy>> TuningArguments::resolve() const {
    const auto estimator = estimator_preset(preset);
    if (!estimator)
        return Error{fmt::format("--preset {}: there is no such preset (one of {})", preset,
                                 fmt::join(estimator_preset_names(), ", ")),
                     EINVAL};
    auto tuning = std::pair(*estimator, GatePolicy{});
    for (const std::string &assignment : assignments) {
        const std::size_t equals = assignment.find('=');
        if (equals == std::string::npos)
            return Error{fmt::format("--set {}: not of the form key=value", assignment), EINVAL};
        const Status set = set_parameter(tuning.first, tuning.second, assignment.substr(0, equals),
                                         assignment.substr(equals + 1));
        if (!set)
            return Error{"--set " + set.error().message, EINVAL};
    }
    return tuning;
}

void RunArguments::add_to(CLI::App &command) {
    command
        .add_option("dataset", dataset,
                    fmt::format("Folder in TUM layout, or the word {}", synthetic_name))
        ->required();
    tuning.add_to(command);
    command.add_option("--frames", frames, "Only the first so many; 0 = all")
        ->check(CLI::NonNegativeNumber);
    command
        .add_option("--wake-latency", wake_latency,
                    "Images between light on and the first depth map")
        ->check(CLI::NonNegativeNumber);
    command
        .add_option("--workers", workers, "Threads that share the work; no result depends on it")
        ->check(CLI::Range(1, 64));
    command.add_option("--seed", seed, "Of the synthetic room");
    command.add_option("--motion", motion, "Speed of the synthetic camera, relative; 0 = still")
        ->check(CLI::Range(0.0, 100.0));
    command.add_flag("--noise,!--no-noise", noise, "The synthetic cameras' noise");
    command.add_flag("--json", json, "Print one JSON object");
    command.add_option("--csv", csv, "Write a line for each frame to this file");
    command.add_option("--dump", dump, "Write the published depth maps and frames.csv here");
}

Status run(const RunArguments &arguments) {
    const auto tuning = arguments.tuning.resolve();
    if (!tuning)
        return tuning.error();
    auto footage = open_footage(arguments);
    if (!footage)
        return footage.error();
    if (!arguments.dump.empty())
        if (Status made = make_folder(arguments.dump); !made)
            return made;

    EvaluationOptions options{.estimator = tuning->first,
                              .gate = tuning->second,
                              .workers = arguments.workers,
                              .publish = {},
                              .progress = {}};
    if (!arguments.dump.empty())
        options.publish = [&](std::uint64_t index, DepthView depth) {
            return dump_depth(arguments.dump, index, depth);
        };
    Progress progress(footage->name, footage->frames);
    options.progress = [&](int done) { progress.update(done); };
    const auto evaluation = evaluate(*footage, options);
    if (!evaluation)
        return evaluation.error();

    if (!arguments.dump.empty())
        if (Status written = write_frames_csv(arguments.dump + "/frames.csv", *evaluation);
            !written)
            return written;
    if (!arguments.csv.empty())
        if (Status written = write_frames_csv(arguments.csv, *evaluation); !written)
            return written;
    if (!evaluation->problem.empty())
        fmt::print(stderr, "afterglow-eval: {}\n", evaluation->problem);
    if (evaluation->frames.empty())
        return Error{fmt::format("{}: not one usable frame", arguments.dataset)};
    const Summary summary = summarize(*evaluation, footage->name, arguments.tuning.preset);
    fmt::print("{}", arguments.json ? to_json(summary) + "\n" : to_text(summary));
    return ok();
}

} // namespace afterglow
