// SPDX-License-Identifier: Apache-2.0
#include "eval/report/report.hpp"

#include "core/base/printable.hpp"
#include "eval/experiments/ablation.hpp"
#include "eval/experiments/example.hpp"
#include "eval/experiments/infill.hpp"
#include "eval/experiments/ransac_experiment.hpp"
#include "eval/experiments/timing.hpp"
#include "eval/experiments/tradeoff.hpp"
#include "eval/report/results_json.hpp"
#include "eval/report/table.hpp"
#include "eval/report/write_report.hpp"
#include "eval/run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace afterglow {
namespace {

constexpr int ransac_trials = 1000;

template <class T>
void append(std::vector<T> &all, std::vector<T> more) {
    all.insert(all.end(), std::move_iterator(more.begin()), std::move_iterator(more.end()));
}

/// All tables; of a report of many experiments, which has more than a person reads on a terminal,
/// the first.
void print(const Results &results, const Experiments &what, const std::string &out) {
    auto tables = make_tables(results);
    if (what.compare && what.runtime && !tables.empty())
        tables.resize(1);
    for (const Table &table : tables)
        fmt::print("{}\n", to_text(table));
    fmt::print("{}/index.html{}\n", out, results.complete ? "" : " (partial)");
}

/// "8 x Intel(R) Core(TM) i7", as Linux names the processor; its architecture where it does not.
std::string cpu_model() {
    std::string model;
    std::ifstream cpus("/proc/cpuinfo");
    for (std::string line; model.empty() && std::getline(cpus, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos)
            model = line.substr(line.find(": ") + 2);
    if (utsname system{}; model.empty() && ::uname(&system) == 0)
        model = system.machine;
    return fmt::format("{} x {}", std::thread::hardware_concurrency(), model);
}

/// One of the experiments on a sequence.
struct Step {
    bool asked;
    const char *name;
    double work; ///< as Watch counts it; an estimate
    std::function<void()> job;
};

/// Runs the experiments. The report is written after each, so that an interrupted run leaves one.
class ExperimentRun {
public:
    explicit ExperimentRun(const ReportArguments &arguments)
        : arguments_(arguments), what_(arguments.experiments), watch_(work_planned()) {
        results_.complete = false; // until it is
        results_.version = AFTERGLOW_VERSION;
        results_.machine = cpu_model();
        results_.date = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
    }

    Status run() {
        if (const auto missing = nothing_there())
            return *missing; // and the report that may be there stays
        if (what_.ransac)
            results_.ransac = simulate_ransac(ransac_trials);
        if (Status saved = save(); !saved)
            return saved;
        bool timed = false;
        for (const std::string &source : arguments_.datasets) {
            const auto sequence = read(source, !timed);
            if (Watch::stopped())
                break;
            if (!sequence)
                continue;
            if (Status done = examine(source, *sequence, !timed); !done)
                return done;
            timed = true;
        }
        results_.complete = !Watch::stopped() && problem_.empty();
        if (Status saved = save(); !saved)
            return saved;
        print(results_, what_, arguments_.out);
        return problem_.empty() ? ok() : Status(Error{problem_});
    }

private:
    /// What is said where not one of the datasets is there.
    std::optional<Error> nothing_there() const {
        const auto made = synthetic_sources();
        const auto is_there = [&](const std::string &source) {
            std::error_code ignored;
            return std::ranges::find(made, source) != made.end() ||
                   std::filesystem::exists(source, ignored);
        };
        const auto &all = arguments_.datasets;
        if (all.empty() || std::ranges::any_of(all, is_there))
            return std::nullopt;
        return Error{fmt::format("{}: there is no such folder", printable(all.front())), ENOENT};
    }

    /// Sequences of one name are told apart: "seq-01", "seq-01 (2)".
    std::string own_name(const std::string &name) {
        const int count = ++names_[name];
        return count == 1 ? name : fmt::format("{} ({})", name, count);
    }

    Status save() const { return write_report(arguments_.out, results_); }

    double frames_planned() const { return arguments_.frames > 0 ? arguments_.frames : 100; }

    double work_planned() {
        double work = 0;
        for (std::size_t i = 0; i < arguments_.datasets.size(); ++i)
            work += frames_planned() + work_of(arguments_.datasets[i], frames_planned(), i == 0);
        return work;
    }

    /// The work of the experiments on a sequence, reading it aside.
    double work_of(const std::string &source, double frames, bool timed) {
        double work = 0;
        for (const Step &step : steps(source, nullptr, frames, timed))
            work += step.asked ? step.work : 0;
        return work;
    }

    /// A sequence that cannot be read is left out, with a note.
    std::optional<Sequence> read(const std::string &source, bool timed) {
        watch_.begin("reading " + source, frames_planned());
        auto sequence = load_sequence(source, arguments_.frames, watch_);
        watch_.end();
        const double planned = work_of(source, frames_planned(), timed);
        if (sequence) {
            sequence->name = own_name(sequence->name);
            watch_.add(work_of(source, static_cast<double>(sequence->frames.size()), timed) -
                       planned);
            if (!sequence->note.empty())
                results_.notes.push_back(sequence->note);
            return *std::move(sequence);
        }
        watch_.add(-planned);
        if (!Watch::stopped()) {
            results_.notes.push_back(sequence.error().message);
            if (problem_.empty())
                problem_ = sequence.error().message;
        }
        return std::nullopt;
    }

    /// `sequence`: what the jobs work on. Times are taken where `timed`. What a stage is worth is
    /// not asked of a stand-in: it is one more synthetic room.
    std::vector<Step> steps(const std::string &source, const Sequence *sequence, double frames,
                            bool timed) {
        const int workers = arguments_.workers;
        return {
            {timed && what_.runtime, "times", stages_work(),
             [=, this] {
                 results_.flow_times = time_flow(*sequence, watch_);
                 results_.stage_times = time_stages(*sequence, workers, watch_);
             }},
            {timed && (what_.runtime || what_.power), "frame rates", systems_work(what_.runtime),
             [=, this] {
                 SystemTimes times = time_systems(*sequence, what_.runtime, workers, watch_);
                 results_.system_times = std::move(times.estimates);
                 results_.system_cpu_times = std::move(times.cpu);
                 results_.measured_cpu_times = std::move(times.measured_cpu);
             }},
            {what_.compare || what_.tradeoff || what_.power, "all systems",
             frames * sweep_work(breadth()),
             [=, this] {
                 sweep(*sequence, breadth(), workers, watch_,
                       [this](Score score) { results_.scores.push_back(std::move(score)); });
             }},
            {what_.compare, "pictures", frames * example_work(),
             [=, this] {
                 append(results_.pictures, example(*sequence, results_.scores, workers, watch_));
             }},
            {what_.ablate && !is_stand_in(source), "ablation", frames * ablation_work(),
             [=, this] {
                 append(results_.ablations, ablate_sequence(*sequence, workers, watch_));
             }},
            {what_.infill, "infilling", frames * infill_work(),
             [=, this] {
                 Infill found = infill(*sequence, workers, watch_);
                 append(results_.infill, std::move(found.scores));
                 append(results_.pictures, std::move(found.pictures));
             }},
        };
    }

    Sweep breadth() const {
        return what_.tradeoff ? Sweep::full : what_.compare ? Sweep::matched : Sweep::adaptive;
    }

    Status examine(const std::string &source, const Sequence &sequence, bool timed) {
        for (const Step &step :
             steps(source, &sequence, static_cast<double>(sequence.frames.size()), timed)) {
            if (!step.asked || Watch::stopped())
                continue;
            watch_.begin(sequence.name + ", " + step.name, step.work);
            step.job();
            watch_.end();
            if (Status saved = save(); !saved)
                return saved;
        }
        return ok();
    }

    const ReportArguments &arguments_;
    const Experiments &what_;
    Results results_;
    std::string problem_;              ///< the first
    std::map<std::string, int> names_; ///< of sequences so far, and how many have each
    Watch watch_;
};

} // namespace

void ReportArguments::add_to(CLI::App &command) {
    command.add_option("--out", out, "Folder for the report")->capture_default_str();
    if (!experiments.need_frames())
        return;
    command
        .add_option("datasets", datasets,
                    fmt::format("Folders in any known layout (docs/datasets.md), or: {}",
                                fmt::join(synthetic_sources(), ", ")))
        ->required();
    command.add_option("--frames", frames, "Only the first so many of each; 0 = all")
        ->capture_default_str()
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    add_workers_option(command, workers);
}

Status report(const ReportArguments &arguments) {
    Watch::heed_signals();
    return ExperimentRun(arguments).run();
}

void MergeArguments::add_to(CLI::App &command) {
    command
        .add_option("files", files,
                    "What afterglow-eval run --json printed, or results.json of reports")
        ->required();
    command.add_option("--out", out, "Folder for the report")->capture_default_str();
}

Status merge(const MergeArguments &arguments) {
    Results results;
    for (const std::string &file : arguments.files)
        if (Status read = read_results(file, results); !read)
            return read;
    if (Status written = write_report(arguments.out, results); !written)
        return written;
    print(results, {}, arguments.out);
    return ok();
}

} // namespace afterglow
