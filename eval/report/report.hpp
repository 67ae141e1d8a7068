// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace afterglow {

/// Which of the paper's experiments are done.
struct Experiments {
    bool compare = false;  ///< Tables III and IV, ablations, pictures
    bool tradeoff = false; ///< the figure of duty cycle against error; holds compare's
    bool runtime = false;  ///< Tables I and V, run-time breakdown
    bool ransac = false;   ///< Table II
    bool power = false;    ///< Table VI, system power
    bool infill = false;   ///< Section VIII
    bool ablate = false;   ///< our own stages, switched off in turn

    static Experiments all() { return {true, true, true, true, true, true, true}; }
    bool need_frames() const { return compare || tradeoff || runtime || power || infill; }
};

/// afterglow-eval compare, tradeoff, runtime, ransac, power, infill, and report, which does them
/// all: a folder with a page, JSON and CSV, and the tables on standard output.
struct ReportArguments {
    Experiments experiments;
    std::vector<std::string> datasets;
    std::string out = "out/report";
    int frames = 100;
    int workers = 2;

    void add_to(CLI::App &command);
};

/// Ctrl-C ends it early with what there is. A dataset that cannot be read is left out; then the
/// report is written, and the Error says which.
Status report(const ReportArguments &arguments);

/// afterglow-eval merge: one report of the output of many `run --json`, or of other reports'
/// results.json.
struct MergeArguments {
    std::vector<std::string> files;
    std::string out = "out/report";

    void add_to(CLI::App &command);
};

Status merge(const MergeArguments &arguments);

} // namespace afterglow
