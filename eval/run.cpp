// SPDX-License-Identifier: Apache-2.0
#include "eval/run.hpp"

#include "config/parameter_table.hpp"
#include "core/base/printable.hpp"
#include "drivers/simulated/synthetic/exposure.hpp"
#include "eval/baselines/oracle.hpp"
#include "eval/dump.hpp"
#include "eval/import.hpp"
#include "eval/progress.hpp"
#include "eval/scoring/evaluation.hpp"
#include "eval/scoring/summary_json.hpp"
#include "eval/settings.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <utility>

namespace afterglow {
namespace {

/// What the score was made with.
nlohmann::json settings_json(const RunArguments &arguments, const std::string &layout,
                             const std::pair<EstimatorOptions, GatePolicy> &tuning) {
    const FootageArguments &footage = arguments.footage;
    return {{"layout", layout},
            {"frames", footage.frames},
            {"wake_latency", footage.wake_latency},
            {"seed", footage.seed},
            {"motion", footage.motion},
            {"noise", footage.noise},
            {"exposure_changes", footage.exposure_changes},
            {"skip", footage.order.skip},
            {"every", footage.order.every},
            {"reverse", footage.order.reverse},
            {"calibration", footage.rig.calibration},
            {"published", footage.rig.published == PublishedCamera::tof ? "tof" : "color"},
            {"depth_interval_ms", arguments.depth_interval_ms},
            {"parameters", parameters_json(tuning.first, tuning.second)}};
}

/// Sets one parameter as `key=value` says.
Status assign(const ParameterTable &table, std::string_view assignment, Method method,
              std::string_view preset) {
    const std::size_t equals = assignment.find('=');
    const std::string_view key = assignment.substr(0, equals);
    const auto refuse = [&](std::string_view why) {
        return Error{fmt::format("--set {}: {}", printable(key), why), EINVAL};
    };
    if (equals == std::string_view::npos)
        return refuse("not of the form key=value");
    const Parameter *parameter = table.find(key);
    if (!parameter)
        return refuse(table.unknown(key, false) + " (afterglow-eval parameters lists them)");
    if (const Status done = assign_text(*parameter, assignment.substr(equals + 1)); !done)
        return refuse(done.error().message);
    if (parameter->used_by && *parameter->used_by != method)
        return refuse(fmt::format("preset {} does not use it", preset));
    return ok();
}

} // namespace

void TuningArguments::add_to(CLI::App &command) {
    command.add_option("--preset", preset, "Composition of the estimator")->capture_default_str();
    command
        .add_option("--set", assignments,
                    "Override a parameter: key=value; may be repeated (afterglow-eval parameters "
                    "lists them)")
        ->allow_extra_args(false);
}

Result<std::pair<EstimatorOptions, GatePolicy>> TuningArguments::resolve() const {
    const bool oracle = has_oracle && preset == oracle_preset;
    const auto estimator = estimator_preset(oracle ? "default" : preset);
    if (!estimator)
        return Error{fmt::format("--preset {}: there is no such preset (one of {}{})",
                                 printable(preset), fmt::join(estimator_preset_names(), ", "),
                                 has_oracle ? fmt::format(", {}", oracle_preset) : ""),
                     EINVAL};
    Config config;
    config.estimator = *estimator;
    if (oracle)
        config.gate = oracle_gate;
    const ParameterTable table = ParameterTable::of_estimator(config);
    for (const std::string &assignment : assignments)
        if (const Status set = assign(table, assignment, estimator->method, preset); !set)
            return set.error();
    for (const auto &[key, other, sentence] : table.conflicts())
        return Error{fmt::format("--set {}: {}", key, sentence), EINVAL};
    return std::pair(config.estimator, config.gate);
}

void add_frame_options(CLI::App &command, int &frames, int &wake_latency) {
    command.add_option("--frames", frames, "Only the first so many; 0 = all")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    command
        .add_option("--wake-latency", wake_latency,
                    "Images between light on and the first depth map")
        ->check(CLI::Range(0, 1000));
}

void add_workers_option(CLI::App &command, int &workers) {
    command
        .add_option("--workers", workers, "Threads that share the work; no result depends on it")
        ->capture_default_str()
        ->check(CLI::Range(1, 64));
}

void FootageArguments::add_to(CLI::App &command) {
    command.add_option("--layout", layout, "Of the dataset, if it is not recognised")
        ->check(CLI::IsMember(layout_names()));
    add_frame_options(command, frames, wake_latency);
    command.add_option("--seed", seed, "Of the synthetic room")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{4294967295}));
    command.add_option("--motion", motion, "Speed of the synthetic camera, relative; 0 = still")
        ->check(number_between(0, 100));
    command.add_flag("--noise,!--no-noise", noise, "The synthetic cameras' noise");
    command
        .add_option(
            "--exposure-changes", exposure_changes,
            "Let the exposure of the images drift and jump, up to so many stops up and down")
        ->check(number_between(0, Exposure::most_stops));
    command.add_option("--skip", order.skip, "Leave out so many frames at a recording's start")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    command.add_option("--every", order.every, "Show only each so many-th frame of a recording")
        ->check(CLI::Range(1, 1000));
    command.add_flag("--reverse", order.reverse, "Show a recording backwards in time");
}

void FootageArguments::add_rig_to(CLI::App &command) {
    command
        .add_option("--calibration", rig.calibration,
                    "Of the two cameras of a recording whose depth is not registered; without it "
                    "the file calibration.toml in the recording, if it is there")
        ->check(CLI::ExistingFile);
    command
        .add_option_function<std::string>(
            "--published",
            [this](const std::string &view) {
                rig.published = view == "tof" ? PublishedCamera::tof : PublishedCamera::color;
            },
            "Whose view of two cameras is published")
        ->check(CLI::IsMember({"color", "tof"}));
}

std::string synthetic_words() {
    std::string words = synthetic_name;
    for (const SimulatedSensor &sensor : simulated_sensors())
        words += fmt::format(", {}:{} ({})", synthetic_name, sensor.name, sensor.shows);
    return words;
}

bool opens_synthetic_room(const std::string &dataset) {
    return synthetic_tof(dataset) && !std::filesystem::exists(dataset);
}

Result<Footage> FootageArguments::open(const std::string &dataset) const {
    if (opens_synthetic_room(dataset)) {
        if (order != FrameOrder{})
            return Error{
                "--skip, --every and --reverse are of recordings, not of the synthetic room",
                EINVAL};
        if (!layout.empty())
            return Error{"--layout is of recordings, not of the synthetic room", EINVAL};
        if (!rig.calibration.empty() || rig.published != PublishedCamera::color)
            return Error{"--calibration and --published are of recordings, not of the synthetic "
                         "room (afterglow-eval rigs has two cameras in it)",
                         EINVAL};
        SyntheticOptions options;
        options.seed = seed;
        options.wake_latency_frames = wake_latency;
        options.frames = frames > 0 ? frames : synthetic_frames;
        options.noise = noise;
        options.motion = motion;
        options.exposure_changes = exposure_changes;
        return open_synthetic_footage(options, dataset);
    }
    if (seed != FootageArguments{}.seed || motion != FootageArguments{}.motion || !noise)
        return Error{"--seed, --motion and --no-noise are of the synthetic room, not of recordings",
                     EINVAL};
    auto footage = open_recorded_footage(dataset, {.layout = layout,
                                                   .frames = frames,
                                                   .wake_latency = wake_latency,
                                                   .order = order,
                                                   .exposure_changes = exposure_changes,
                                                   .rig = rig});
    if (footage && !footage->assumed.empty())
        fmt::print(stderr, "{}: {}\n", dataset, footage->assumed);
    return footage;
}

Status list_parameters(const ParametersArguments &arguments) {
    const auto tuning = arguments.tuning.resolve();
    if (!tuning)
        return tuning.error();
    fmt::print("{}", parameters_text(tuning->first, tuning->second));
    return ok();
}

void RunArguments::add_to(CLI::App &command) {
    command
        .add_option("dataset", dataset,
                    "Folder in a known layout (docs/datasets.md), or " + synthetic_words())
        ->required();
    tuning.add_to(command);
    footage.add_to(command);
    footage.add_rig_to(command);
    add_workers_option(command, workers);
    command
        .add_option("--depth-interval", depth_interval_ms,
                    "Make a depth map once in so many ms, as for a reader with this interval; 0 = "
                    "for every image")
        ->check(CLI::Range(0, 1000));
    command.add_flag("--json", json, "Print one JSON object");
    command.add_option("--csv", csv, "Write a line for each frame to this file");
    command.add_option("--dump", dump, "Write the published depth maps and frames.csv here");
}

Status run(const RunArguments &arguments) {
    const auto tuning = arguments.tuning.resolve();
    if (!tuning)
        return tuning.error();
    FootageArguments how = arguments.footage;
    // The oracle and the paper's pipeline do without lenses.
    how.rig.allowed =
        tuning->first.method == Method::keyframe && arguments.tuning.preset != oracle_preset;
    auto footage = how.open(arguments.dataset);
    if (!footage)
        return footage.error();
    if (!arguments.dump.empty())
        if (Status made = make_folder(arguments.dump); !made)
            return made;

    WorkerPool pool(arguments.workers);
    EvaluationHooks hooks;
    if (!arguments.dump.empty())
        hooks.publish = [&](std::uint64_t index, const Estimate &estimate) {
            return dump_depth(arguments.dump, index, estimate.depth);
        };
    Progress progress(footage->name, footage->frames);
    hooks.progress = [&](int done) {
        progress.update(done);
        return true;
    };
    const PipelineFactory make = arguments.tuning.preset == oracle_preset
                                     ? oracle_factory(tuning->first, pool, footage->truth_at())
                                     : pipeline_factory(tuning->first, pool);
    const auto evaluation = evaluate(*footage, make, tuning->second, hooks,
                                     std::chrono::milliseconds(arguments.depth_interval_ms));
    if (!evaluation)
        return evaluation.error();

    if (!arguments.dump.empty())
        if (Status written = write_frames_csv(arguments.dump + "/frames.csv", *evaluation);
            !written)
            return written;
    if (Status scored = check_scored(*evaluation, arguments.dataset); !scored)
        return scored;
    if (!evaluation->problem.empty())
        fmt::print(stderr, "afterglow-eval: {}\n", evaluation->problem);
    const Summary summary =
        summarize(*evaluation, footage->name, arguments.tuning.preset, tuning->second.target_mre);
    nlohmann::json object = summary;
    object["settings"] = settings_json(arguments, footage->layout, *tuning);
    fmt::print("{}", arguments.json ? json_text(object) + "\n" : to_text(summary));
    return arguments.csv.empty() ? ok() : write_frames_csv(arguments.csv, *evaluation);
}

} // namespace afterglow
