// SPDX-License-Identifier: Apache-2.0
#include "eval/scoring/metrics.hpp"

#include <cassert>
#include <cmath>

namespace afterglow {

DepthErrors compare_depth(DepthView estimate, DepthView truth) {
    assert(estimate.same_size(truth));
    DepthErrors errors;
    double relative = 0;
    double absolute = 0;
    double squared = 0;
    for (int v = 0; v < truth.height(); ++v) {
        const std::uint16_t *estimated = estimate.row(v);
        const std::uint16_t *known = truth.row(v);
        for (int u = 0; u < truth.width(); ++u) {
            if (known[u] == 0)
                continue;
            ++errors.true_pixels;
            if (estimated[u] == 0)
                continue;
            ++errors.pixels;
            const double difference = std::abs(static_cast<double>(known[u]) - estimated[u]);
            relative += difference / known[u];
            absolute += difference;
            squared += difference * difference;
        }
    }
    if (errors.pixels > 0) {
        const auto n = static_cast<double>(errors.pixels);
        errors.mre = 100 * relative / n;
        errors.mae_cm = absolute / n / 10;
        errors.rmse_cm = std::sqrt(squared / n) / 10;
    }
    return errors;
}

} // namespace afterglow
