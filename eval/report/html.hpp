// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"

#include <string>

namespace afterglow {

/// One page that needs nothing but itself: tables, plots as SVG, pictures as data. Light or dark as
/// the reader's browser is, readable on a telephone and on paper.
std::string to_html(const Results &results);

} // namespace afterglow
