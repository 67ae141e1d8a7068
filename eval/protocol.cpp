// SPDX-License-Identifier: Apache-2.0
#include "eval/protocol.hpp"

#include "core/pipeline.hpp"
#include "eval/baselines/oracle.hpp"
#include "eval/datasets/dataset.hpp"
#include "eval/progress.hpp"
#include "eval/scoring/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace afterglow {
namespace {

/// One way to show a dataset.
struct Showing {
    std::string name;
    FrameOrder order{};
    std::uint64_t seed = 1;
    bool shifted = false; ///< counts for the spread
};

std::vector<Showing> showings(const ProtocolArguments &arguments, bool synthetic) {
    std::vector<Showing> all;
    if (synthetic) { // has no other order; another seed is another room and another way through it
        for (std::uint64_t seed = 1; seed <= 1 + arguments.shifts.size(); ++seed)
            all.push_back({.name = fmt::format("seed {}", seed), .seed = seed, .shifted = true});
        return all;
    }
    all = {{.name = "forwards", .shifted = true},
           {.name = "backwards", .order = {.reverse = true}},
           {.name = "every 2nd", .order = {.every = 2}}};
    for (const int shift : arguments.shifts)
        all.push_back(
            {.name = fmt::format("from {}", shift), .order = {.skip = shift}, .shifted = true});
    return all;
}

struct Column {
    const char *title;
    std::optional<double> (*of)(const Summary &summary);
    int digits;
    bool compared; ///< as a ratio to the same with the pose from the true depth
};

constexpr Column columns[] = {
    {"lit %", [](const Summary &s) { return std::optional(s.duty_cycle); }, 1, true},
    {"meas. %", [](const Summary &s) { return std::optional(s.measured_share); }, 1, false},
    {"MRE med", [](const Summary &s) { return s.mre_median; }, 2, true},
    {"MRE p95", [](const Summary &s) { return s.mre_p95; }, 2, true},
    {"cov.med", [](const Summary &s) { return s.coverage_median; }, 1, false},
    {"cov. p5", [](const Summary &s) { return s.coverage_p5; }, 1, false},
    {"tru/exp", [](const Summary &s) { return s.true_over_expected; }, 2, false},
    {">1.5x %", [](const Summary &s) { return s.misjudged_share; }, 1, false},
    {"corr.", [](const Summary &s) { return s.expected_correlation; }, 2, false},
};
using Row = std::array<std::optional<double>, std::size(columns)>;

TuningArguments tuning_of(const ProtocolArguments &arguments, bool oracle) {
    TuningArguments tuning = arguments.tuning;
    tuning.has_oracle = true;
    if (oracle)
        tuning.preset = oracle_preset;
    return tuning;
}

Result<Row> score(const ProtocolArguments &arguments, const std::string &dataset,
                  const Showing &showing, bool oracle, WorkerPool &pool) {
    const TuningArguments tuning = tuning_of(arguments, oracle);
    const auto resolved = tuning.resolve();
    if (!resolved)
        return resolved.error();
    FootageArguments how;
    how.frames = arguments.frames;
    how.wake_latency = arguments.wake_latency;
    how.order = showing.order;
    how.seed = showing.seed;
    auto footage = how.open(dataset);
    if (!footage)
        return footage.error();
    const PipelineFactory make = oracle ? oracle_factory(resolved->first, pool, footage->truth_at())
                                        : pipeline_factory(resolved->first, pool);
    const auto evaluation = evaluate(*footage, make, resolved->second);
    if (!evaluation)
        return evaluation.error();
    if (Status scored = check_scored(*evaluation, dataset); !scored)
        return scored.error();
    const Summary summary =
        summarize(*evaluation, footage->name, tuning.preset, resolved->second.target_mre);
    Row row;
    std::ranges::transform(columns, row.begin(),
                           [&](const Column &column) { return column.of(summary); });
    return row;
}

void print(const std::string &name, const Row &row, int more_digits = 0) {
    fmt::print("{:<22}", name);
    for (std::size_t i = 0; i < row.size(); ++i)
        fmt::print("{:>8}",
                   row[i] ? fmt::format("{:.{}f}", *row[i], columns[i].digits + more_digits) : "-");
    fmt::print("\n");
}

void print_heading(const std::string &name) {
    fmt::print("{:<22}", name);
    for (const Column &column : columns)
        fmt::print("{:>8}", column.title);
    fmt::print("\n");
}

/// Least and greatest of each column.
void print_spread(const std::vector<Row> &rows) {
    Row least, most;
    for (const Row &row : rows)
        for (std::size_t i = 0; i < row.size(); ++i)
            if (row[i]) {
                least[i] = std::min(least[i].value_or(*row[i]), *row[i]);
                most[i] = std::max(most[i].value_or(*row[i]), *row[i]);
            }
    print("  starts, least", least);
    print("  starts, most", most);
}

/// Geometric means of the ratios of the compared columns; pairs without a positive value on both
/// sides are left out.
class RatioMeans {
public:
    void add(const Row &row, const Row &reference) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (!columns[i].compared || !(row[i] > 0.0) || !(reference[i] > 0.0))
                continue;
            sums_[i] += std::log(*row[i] / *reference[i]);
            ++counts_[i];
        }
    }
    Row means() const {
        Row means;
        for (std::size_t i = 0; i < means.size(); ++i)
            if (counts_[i] > 0)
                means[i] = std::exp(sums_[i] / counts_[i]);
        return means;
    }

private:
    std::array<double, std::size(columns)> sums_{};
    std::array<int, std::size(columns)> counts_{};
};

} // namespace

void ProtocolArguments::add_to(CLI::App &command) {
    command
        .add_option("datasets", datasets,
                    "Folders in known layouts (docs/datasets.md), or " + synthetic_words())
        ->required();
    tuning.add_to(command);
    command
        .add_option("--shifts", shifts,
                    "Starts besides the first frame, as a list; of the room as many more seeds")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    add_frame_options(command, frames, wake_latency);
    command.add_flag("--oracle,!--no-oracle", oracle,
                     "Score the same with the pose from the true depth, too");
    add_workers_option(command, workers);
}

Status protocol(const ProtocolArguments &arguments) {
    if (arguments.oracle)
        if (const auto tuning = tuning_of(arguments, true).resolve(); !tuning)
            return Error{tuning.error().message + " (--no-oracle leaves it out)",
                         tuning.error().code};
    WorkerPool pool(arguments.workers);
    RatioMeans all_ratios;
    Progress progress("", static_cast<double>(arguments.datasets.size()));
    double done = 0;
    for (const std::string &dataset : arguments.datasets) {
        const bool synthetic = opens_synthetic_room(dataset);
        const std::vector<Showing> all = showings(arguments, synthetic);
        std::vector<Row> shifted;
        RatioMeans ratios;
        print_heading(synthetic ? dataset : folder_name(dataset));
        for (const Showing &showing : all) {
            progress.set_what(fmt::format("{}, {}", dataset, showing.name));
            progress.update(done);
            done += 1 / static_cast<double>(all.size());
            const auto row = score(arguments, dataset, showing, false, pool);
            if (!row)
                return row.error();
            print("  " + showing.name, *row);
            if (showing.shifted)
                shifted.push_back(*row);
            if (arguments.oracle) {
                const auto reference = score(arguments, dataset, showing, true, pool);
                if (!reference)
                    return reference.error();
                print("    true-depth pose", *reference);
                ratios.add(*row, *reference);
                all_ratios.add(*row, *reference);
            }
            std::fflush(stdout);
        }
        print_spread(shifted);
        if (arguments.oracle)
            print("  / true-depth pose", ratios.means(), 1);
        fmt::print("\n");
    }
    if (arguments.oracle) {
        print_heading("all");
        print("  / true-depth pose", all_ratios.means(), 1);
        fmt::print("/ true-depth pose: geometric mean of the ratios to the same frames with the "
                   "pose refined\non the true depth and lit by the true error and coverage; no "
                   "bound, for the "
                   "gates light different frames\n");
    }
    return ok();
}

} // namespace afterglow
