// SPDX-License-Identifier: Apache-2.0
#include "eval/protocol.hpp"

#include "core/pipeline.hpp"
#include "eval/baselines/oracle.hpp"
#include "eval/progress.hpp"
#include "eval/scoring/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace afterglow {
namespace {

constexpr int learning_measurements = 3;
constexpr double too_wrong = 1.5;

/// One way to show a recording.
struct Showing {
    std::string name;
    FrameOrder order;
    bool shifted; ///< counts for the spread over shifted starts
};

std::vector<Showing> showings(const std::vector<int> &shifts) {
    std::vector<Showing> all{{"forwards", {}, true},
                             {"backwards", {.reverse = true}, false},
                             {"every 2nd", {.every = 2}, false}};
    for (const int shift : shifts)
        all.push_back({fmt::format("from {}", shift), {.skip = shift}, true});
    return all;
}

constexpr std::array<const char *, 8> titles{"duty %",  "MRE med",  "MRE p95",  "cov. med",
                                             "cov. p5", "true/exp", ">1.5 exp", "corr."};
using Row = std::array<std::optional<double>, titles.size()>;
/// The first so many are compared with the oracle's.
constexpr std::size_t against_oracle = 3;

Row row_of(const Evaluation &evaluation, const std::string &name, double target_mre) {
    const Summary s = summarize(evaluation, name, "", target_mre);
    const ExpectedAgainstTrue e = expected_against_true(evaluation);
    return {s.duty_cycle,  s.mre_median, s.mre_p95, s.coverage_median,
            s.coverage_p5, e.ratio,      e.over,    e.correlation};
}

Result<Row> score(const ProtocolArguments &arguments, const std::string &dataset,
                  const Showing &showing, bool oracle, WorkerPool &pool) {
    TuningArguments tuning = arguments.tuning;
    tuning.has_oracle = true;
    if (oracle)
        tuning.preset = oracle_preset;
    const auto resolved = tuning.resolve();
    if (!resolved)
        return resolved.error();
    FootageArguments how;
    how.order = showing.order;
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
    return row_of(*evaluation, footage->name, resolved->second.target_mre);
}

std::string line(const std::string &name, const Row &row) {
    std::string out = fmt::format("{:<28}", name);
    for (const auto &value : row)
        out += value ? fmt::format("{:>9.2f}", *value) : fmt::format("{:>9}", "-");
    return out + "\n";
}

/// Least and greatest of each column.
std::string spread(const std::vector<Row> &rows) {
    std::string out = fmt::format("{:<28}", "  spread over starts");
    for (std::size_t i = 0; i < titles.size(); ++i) {
        std::vector<double> values;
        for (const Row &row : rows)
            if (row[i])
                values.push_back(*row[i]);
        out += values.empty()
                   ? fmt::format("{:>9}", "-")
                   : fmt::format("{:>9}", fmt::format("{:.3g}-{:.3g}", std::ranges::min(values),
                                                      std::ranges::max(values)));
    }
    return out + "\n";
}

/// Geometric mean of the ratios; pairs without a positive value on both sides are left out.
class RatioMean {
public:
    void add(const std::optional<double> &value, const std::optional<double> &reference) {
        if (!value || !reference || !(*value > 0) || !(*reference > 0))
            return;
        sum_ += std::log(*value / *reference);
        ++count_;
    }
    std::optional<double> mean() const {
        return count_ > 0 ? std::optional(std::exp(sum_ / count_)) : std::nullopt;
    }

private:
    double sum_ = 0;
    int count_ = 0;
};

} // namespace

ExpectedAgainstTrue expected_against_true(const Evaluation &evaluation) {
    int measured = 0;
    std::vector<double> ratios, expected, actual;
    for (const FrameScore &frame : evaluation.frames) {
        measured += frame.measured;
        if (frame.measured || measured < learning_measurements || !frame.mre ||
            !frame.expected_mre || !(*frame.expected_mre > 0))
            continue;
        expected.push_back(*frame.expected_mre);
        actual.push_back(*frame.mre);
        ratios.push_back(*frame.mre / *frame.expected_mre);
    }
    if (ratios.empty())
        return {};
    const auto over = std::ranges::count_if(ratios, [](double r) { return r > too_wrong; });
    return {percentile(ratios, 50),
            100.0 * static_cast<double>(over) / static_cast<double>(ratios.size()),
            correlation(expected, actual)};
}

void ProtocolArguments::add_to(CLI::App &command) {
    command.add_option("datasets", datasets, "Folders in known layouts (docs/datasets.md)")
        ->required();
    tuning.add_to(command);
    command.add_option("--shifts", shifts, "Starts besides the first frame, as a list")
        ->delimiter(',')
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command.add_flag("--oracle,!--no-oracle", oracle, "Score the oracle too");
    command
        .add_option("--workers", workers, "Threads that share the work; no result depends on it")
        ->check(CLI::Range(1, 64));
}

Status protocol(const ProtocolArguments &arguments) {
    const std::vector<Showing> all = showings(arguments.shifts);
    WorkerPool pool(arguments.workers);
    std::array<RatioMean, against_oracle> ratios;
    fmt::print("{:<28}", "");
    for (const char *title : titles)
        fmt::print("{:>9}", title);
    fmt::print("\n");
    Progress progress("", static_cast<double>(arguments.datasets.size() * all.size()));
    double done = 0;
    for (const std::string &dataset : arguments.datasets) {
        std::vector<Row> shifted;
        fmt::print("{}\n", dataset);
        for (const Showing &showing : all) {
            progress.set_what(fmt::format("{}, {}", dataset, showing.name));
            progress.update(done++);
            const auto row = score(arguments, dataset, showing, false, pool);
            if (!row)
                return row.error();
            fmt::print("{}", line("  " + showing.name, *row));
            if (showing.shifted)
                shifted.push_back(*row);
            if (arguments.oracle) {
                const auto best = score(arguments, dataset, showing, true, pool);
                if (!best)
                    return best.error();
                fmt::print("{}", line("    oracle", *best));
                for (std::size_t i = 0; i < against_oracle; ++i)
                    ratios[i].add((*row)[i], (*best)[i]);
            }
            std::fflush(stdout);
        }
        fmt::print("{}", spread(shifted));
    }
    if (arguments.oracle) {
        Row means;
        for (std::size_t i = 0; i < against_oracle; ++i)
            means[i] = ratios[i].mean();
        fmt::print("{}", line("geometric mean of / oracle", means));
    }
    return ok();
}

} // namespace afterglow
