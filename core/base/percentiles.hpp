// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace afterglow {

struct Percentiles {
    double p50 = 0;
    double p99 = 0;
    double max = 0;
};

/// By nearest rank: the smallest sample that so many percent of all do not exceed. `samples`: one
/// at least.
inline Percentiles percentiles_of(std::vector<double> samples) {
    std::sort(samples.begin(), samples.end());
    const auto at = [&](double share) {
        const double rank = std::ceil(share * static_cast<double>(samples.size()));
        return samples[static_cast<std::size_t>(rank) - 1];
    };
    return {at(0.5), at(0.99), samples.back()};
}

} // namespace afterglow
