// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/result.hpp"
#include "eval/experiments/results.hpp"

#include <string>

namespace afterglow {

/// Writes index.html, results.json, scores.csv, ablations.csv and a CSV file for each table into
/// the folder, which is made where it is missing. Each file is whole under its name at all times.
Status write_report(const std::string &folder, const Results &results);

} // namespace afterglow
