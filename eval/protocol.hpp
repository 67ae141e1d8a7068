// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/run.hpp"
#include "eval/scoring/evaluation.hpp"

#include <optional>
#include <string>
#include <vector>

namespace afterglow {

/// How well the expected error of an evaluation's estimated frames agrees with the true one, from
/// the third measurement on. Nothing without such a frame.
struct ExpectedAgainstTrue {
    std::optional<double> ratio;       ///< median of true / expected
    std::optional<double> over;        ///< percent of the frames above 1.5 times the expected
    std::optional<double> correlation; ///< Pearson's
};
ExpectedAgainstTrue expected_against_true(const Evaluation &evaluation);

/// afterglow-eval protocol: the table by which constants are judged. Each recording is scored
/// forwards, backwards, with every second frame, and with shifted starts, beside the oracle.
struct ProtocolArguments {
    std::vector<std::string> datasets;
    TuningArguments tuning;
    std::vector<int> shifts{1, 2, 3, 5}; ///< frames left out at the start
    bool oracle = true;
    int workers = 2;

    void add_to(CLI::App &command);
};

Status protocol(const ProtocolArguments &arguments);

} // namespace afterglow
