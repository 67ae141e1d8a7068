// SPDX-License-Identifier: Apache-2.0
//
// afterglow-count: the instructions that ARM processors need for a frame, counted under qemu-user.
#include "core/base/read_file.hpp"
#include "core/base/temporary_directory.hpp"
#include "core/base/write_file.hpp"
#include "eval/json.hpp"
#include "tools/bench/arm/count_tables.hpp"
#include "tools/command_line/run_program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <optional>
#include <thread>

using namespace afterglow;
using namespace afterglow::bench;

namespace {

constexpr int exit_failure = 1;

struct Options {
    std::vector<std::string> datasets;
    std::vector<std::string> targets = {"armv7", "aarch64"};
    std::vector<std::string> presets = {"default", "paper"};
    std::string programs = "build";
    int frames = 40;
    int still = 20;
    bool depth_alone = false;
    int depth_interval_ms = 0;
    int jobs = 1;
    std::string json_file;
    std::string check_file;
    double margin = 3;

    void add_to(CLI::App &app) {
        app.add_option("dataset", datasets,
                       "Folders in a known layout (docs/datasets.md), or "
                       "synthetic rooms")
            ->required();
        app.add_option("--target", targets, "Kinds of processor")
            ->check(CLI::IsMember({"armv7", "aarch64"}))
            ->capture_default_str();
        app.add_option("--preset", presets, "Compositions of the estimator")
            ->check(CLI::IsMember({"default", "paper"}))
            ->capture_default_str();
        app.add_option("--programs", programs, "Where TARGET/bin/afterglow-counted are")
            ->capture_default_str();
        app.add_option("--frames", frames, "Only the first so many")
            ->check(CLI::Range(1, 100000))
            ->capture_default_str();
        app.add_option("--still", still, "How often the last image is shown again, unmeasured")
            ->check(CLI::Range(1, 100000))
            ->capture_default_str();
        app.add_flag("--depth-alone", depth_alone, "As if no reader asked for confidences");
        app.add_option(
               "--depth-interval", depth_interval_ms,
               "Make a depth map once in so many ms, as for a reader with this interval; 0 = "
               "for every image")
            ->check(CLI::Range(0, 1000));
        app.add_option("--jobs", jobs, "Emulators at a time; no count depends on it")
            ->check(CLI::Range(1, 64));
        app.add_option("--json", json_file, "Write the counts to FILE")->type_name("FILE");
        app.add_option("--check", check_file, "Fail where counts are above those of FILE")
            ->type_name("FILE");
        app.add_option("--margin", margin, "Percent that they may be above")
            ->check(number_between(0, 1000))
            ->capture_default_str();
    }
};

/// A sequence, a preset and a target.
struct Job {
    std::string sequence;
    CountedRun run;
    std::optional<Result<Counts>> counts{};
};

Result<std::vector<Job>> plan(const Options &options, const std::string &folder) {
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < options.datasets.size(); ++i) {
        const auto frames = load_frames(options.datasets[i], options.frames);
        if (!frames)
            return frames.error();
        const std::string file = fmt::format("{}/frames{}", folder, i);
        if (Status written = write_frames(*frames, file); !written)
            return written.error();
        for (const Target &target : targets)
            for (const std::string &preset : options.presets)
                if (std::ranges::count(options.targets, target.name) > 0)
                    jobs.push_back({.sequence = frames->name,
                                    .run = {.target = target,
                                            .program = fmt::format("{}/{}/bin/afterglow-counted",
                                                                   options.programs, target.name),
                                            .preset = preset,
                                            .frames_file = file,
                                            .frames = static_cast<int>(frames->frames.size()),
                                            .still = options.still,
                                            .depth_alone = options.depth_alone,
                                            .depth_interval_ms = options.depth_interval_ms,
                                            .folder = {}}});
    }
    return jobs;
}

void work(std::vector<Job> &jobs, std::atomic<std::size_t> &next) {
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
        Job &job = jobs[i];
        const auto own = TemporaryDirectory::create("afterglow-count-");
        if (!own) {
            job.counts = own.error();
            continue;
        }
        job.run.folder = own->path();
        job.counts = count_instructions(job.run);
        fmt::print(stderr, "{}, {}, {}: {}\n", job.sequence, job.run.preset, job.run.target.name,
                   *job.counts ? "counted" : "failed");
    }
}

Result<std::vector<CountedSequence>> count_all(const Options &options) {
    const auto folder = TemporaryDirectory::create("afterglow-count-");
    if (!folder)
        return folder.error();
    auto jobs = plan(options, folder->path());
    if (!jobs)
        return jobs.error();
    std::atomic<std::size_t> next = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < options.jobs; ++i)
            threads.emplace_back([&] { work(*jobs, next); });
    }
    std::vector<CountedSequence> counted;
    for (Job &job : *jobs) {
        if (!*job.counts)
            return job.counts->error();
        std::string made = job.run.preset;
        if (job.run.depth_alone)
            made += "/depth";
        if (job.run.depth_interval_ms > 0)
            made += fmt::format("/{} ms", job.run.depth_interval_ms);
        counted.push_back({job.sequence, std::move(made), std::string(job.run.target.name),
                           *std::move(*job.counts)});
    }
    return counted;
}

Status compare(const Options &options, const nlohmann::json &summaries) {
    const auto text = read_file(options.check_file);
    if (!text)
        return text.error();
    const nlohmann::json baseline = nlohmann::json::parse(*text, nullptr, false);
    if (!baseline.is_array())
        return Error{options.check_file + " is not what --json writes", EINVAL};
    const std::string above = regressions(summaries, baseline, options.margin);
    if (!above.empty())
        return Error{
            fmt::format("more than {} % above {}:\n{}", options.margin, options.check_file, above),
            0};
    return ok();
}

Status run(const Options &options) {
    const auto counted = count_all(options);
    if (!counted)
        return counted.error();
    nlohmann::json summaries = nlohmann::json::array();
    std::string table = summary_head();
    std::string stages;
    for (const CountedSequence &sequence : *counted) {
        summaries.push_back(summary_of(sequence));
        table += summary_line(sequence);
        stages += stage_table(sequence);
    }
    fmt::print("{}{}", table, stages);
    if (!options.json_file.empty())
        if (Status written = write_file(options.json_file, json_text(summaries, 2) + "\n");
            !written)
            return written;
    return options.check_file.empty() ? ok() : compare(options, summaries);
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Counts the instructions that ARM processors need for a frame, under qemu-user.",
                 "afterglow-count");
    Options options;
    options.add_to(app);
    return run_program(app, argc, argv, [&]() -> Result<int> {
        const Status done = run(options);
        return done ? Result<int>(0) : done.error();
    });
}
