// SPDX-License-Identifier: Apache-2.0
#include "tools/eval/report/report.hpp"

#include "tools/eval/report/example.hpp"
#include "tools/eval/report/infill.hpp"
#include "tools/eval/report/ransac_experiment.hpp"
#include "tools/eval/report/results_json.hpp"
#include "tools/eval/report/table.hpp"
#include "tools/eval/report/timing.hpp"
#include "tools/eval/report/tradeoff.hpp"
#include "tools/eval/report/write_report.hpp"

#include <fmt/format.h>

#include <iterator>
#include <limits>

namespace afterglow {
namespace {

constexpr int ransac_trials = 1000;

template <class T>
void append(std::vector<T> &all, std::vector<T> more) {
    all.insert(all.end(), std::move_iterator(more.begin()), std::move_iterator(more.end()));
}

/// The experiments on one sequence. Times are taken where `timed`.
void experiment(const Sequence &sequence, const ReportArguments &arguments, bool timed,
                Results &results) {
    const Experiments &what = arguments.experiments;
    if (timed && what.runtime) {
        const Watch watch("run times", 2 * least_rounds);
        results.flow_times = time_flow(sequence, watch);
        results.stage_times = time_stages(sequence, arguments.workers, watch);
    }
    if (timed && (what.runtime || what.power)) {
        const Watch watch("frame rates", least_rounds);
        results.system_times = time_systems(sequence, what.runtime, arguments.workers, watch);
    }
    if (what.compare || what.tradeoff || what.power)
        sweep(sequence,
              what.tradeoff  ? Sweep::full
              : what.compare ? Sweep::matched
                             : Sweep::adaptive,
              arguments.workers, [&](Score score) { results.scores.push_back(std::move(score)); });
    if (what.compare) {
        const Watch watch("pictures", 3 * static_cast<int>(sequence.frames.size()));
        append(results.pictures, example(sequence, results.scores, arguments.workers, watch));
    }
    if (what.infill) {
        const Watch watch("infilling", infill_frames(sequence));
        Infill found = infill(sequence, arguments.workers, watch);
        append(results.infill, std::move(found.scores));
        append(results.pictures, std::move(found.pictures));
    }
}

Status finish(const std::string &out, const Results &results) {
    if (Status written = write_report(out, results); !written)
        return written;
    for (const Table &table : make_tables(results))
        fmt::print("{}\n", to_text(table));
    fmt::print("{}/index.html{}\n", out, results.complete ? "" : " (partial)");
    return ok();
}

} // namespace

void ReportArguments::add_to(CLI::App &command) {
    command.add_option("--out", out, "Folder for the report")->capture_default_str();
    if (!experiments.need_frames())
        return;
    command
        .add_option("datasets", datasets,
                    "Folders in any known layout (docs/datasets.md), or the word synthetic")
        ->required();
    command.add_option("--frames", frames, "Only the first so many of each; 0 = all")
        ->capture_default_str()
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    command.add_option("--workers", workers, "Threads")
        ->capture_default_str()
        ->check(CLI::Range(1, 64));
}

Status report(const ReportArguments &arguments) {
    Watch::heed_signals();
    Results results;
    std::string problem;
    if (arguments.experiments.ransac)
        results.ransac = simulate_ransac(ransac_trials);
    bool timed = false;
    for (const std::string &source : arguments.datasets) {
        if (Watch::stopped())
            break;
        const Watch loading("reading " + source, arguments.frames);
        const auto sequence = load_sequence(source, arguments.frames, loading);
        if (!sequence) {
            if (Watch::stopped())
                break;
            results.notes.push_back(sequence.error().message);
            if (problem.empty())
                problem = sequence.error().message;
            continue;
        }
        if (!sequence->note.empty())
            results.notes.push_back(sequence->note);
        experiment(*sequence, arguments, !timed, results);
        timed = true;
        results.complete = false; // until it is: this one stays if the rest is killed
        if (Status written = write_report(arguments.out, results); !written)
            return written;
    }
    results.complete = !Watch::stopped() && problem.empty();
    if (Status finished = finish(arguments.out, results); !finished)
        return finished;
    return problem.empty() ? ok() : Status(Error{problem});
}

void MergeArguments::add_to(CLI::App &command) {
    command.add_option("files", files, "What afterglow-eval run --json printed")->required();
    command.add_option("--out", out, "Folder for the report")->capture_default_str();
}

Status merge(const MergeArguments &arguments) {
    Results results;
    for (const std::string &file : arguments.files) {
        auto scores = read_scores(file);
        if (!scores)
            return scores.error();
        append(results.scores, *std::move(scores));
    }
    return finish(arguments.out, results);
}

} // namespace afterglow
