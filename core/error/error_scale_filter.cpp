// SPDX-License-Identifier: Apache-2.0
#include "core/error/error_scale_filter.hpp"

#include <cmath>

namespace afterglow {
namespace {

constexpr int fresh_part = 0, carried_part = 1;
/// Standard deviations: of the drift from one reading of a part to the next, and of the noise of
/// readings.
constexpr double drift_deviation = 0.45;
constexpr double fresh_noise = 0.4, carried_noise = 0.9;

bool is_error(double error) {
    return error > 0 && std::isfinite(error);
}

} // namespace

void ErrorScaleFilter::learn_fresh(double error, double fresh) {
    if (!is_error(error) || !is_error(fresh))
        return;
    factors_.drift(fresh_part, drift_deviation);
    factors_.learn(std::log(error / fresh) - factors_.logarithms()[fresh_part],
                   Eigen::Vector2d::Unit(fresh_part), fresh_noise);
}

void ErrorScaleFilter::learn_carried(double error, double fresh, double carried) {
    if (!is_error(error) || !is_error(fresh) || !(carried >= 0 && std::isfinite(carried)))
        return;
    factors_.drift(carried_part, drift_deviation);
    const Eigen::Vector2d parts =
        factors_.logarithms().array().exp() * Eigen::Array2d(fresh, carried);
    const Eigen::Vector2d shares = parts.cwiseAbs2() / parts.squaredNorm();
    factors_.learn(std::log(error / parts.norm()), shares, carried_noise);
}

ErrorScales ErrorScaleFilter::scales() const {
    return {.fresh = static_cast<float>(factors_.mean(fresh_part)),
            .carried = static_cast<float>(factors_.mean(carried_part))};
}

} // namespace afterglow
