// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/experiments/results.hpp"

#include <string>
#include <vector>

namespace afterglow {

/// All results but the pictures as one JSON object; its keys are stable.
std::string to_json(const Results &results);

/// Reads the objects that `afterglow-eval run --json` printed, one or several in a file, or the
/// scores of a results.json. Errors name the file.
Result<std::vector<Score>> read_scores(const std::string &path);

} // namespace afterglow
