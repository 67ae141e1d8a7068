// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "tools/picture/figure.hpp"

#include <vector>

namespace afterglow {

/// All figures for which there are results.
std::vector<Figure> make_figures(const Results &results);

} // namespace afterglow
