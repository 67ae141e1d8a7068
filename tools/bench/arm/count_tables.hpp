// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/bench/arm/counting.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace afterglow::bench {

/// What was counted of a sequence.
struct CountedSequence {
    std::string sequence;
    std::string preset;
    std::string target;
    Counts counts;
};

/// {sequence, preset, target, frames, instructions_mean, instructions_max, instructions_still},
/// means rounded.
nlohmann::json summary_of(const CountedSequence &counted);

/// One line for the table of all sequences, and its first line.
std::string summary_head();
std::string summary_line(const CountedSequence &counted);

/// Where the instructions go: the stages that have at least 1 % of them.
std::string stage_table(const CountedSequence &counted);

/// What in `summaries` is more than in `baseline` by more than `margin` percent, or is not there;
/// one sentence a line, empty when nothing is.
std::string regressions(const nlohmann::json &summaries, const nlohmann::json &baseline,
                        double margin);

} // namespace afterglow::bench
