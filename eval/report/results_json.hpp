// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/experiments/results.hpp"

#include <string>

namespace afterglow {

/// All results but the pictures as one JSON object; its keys are stable.
std::string to_json(const Results &results);

/// Appends the results of a file to `results`: either objects that `afterglow-eval run --json`
/// printed, one or several, or a results.json. Of run times, which are taken once for a report,
/// those of the first file that has them are kept. Errors name the file: errno where it cannot be
/// opened, 0 where its content is not understood; `results` is then unchanged.
Status read_results(const std::string &path, Results &results);

} // namespace afterglow
