// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Standard deviation of the drift of m between two measurements.
constexpr double drift = 0.25;
constexpr double most_deviations = 2.5;
constexpr double least_share = 0.1;

} // namespace

void ErrorScale::learn(double true_error, double modelled_error, double share) {
    const double ratio = true_error / modelled_error;
    if (!(true_error > 0 && modelled_error > 0 && std::isnormal(ratio)))
        return;
    const double deviation = reading_deviation_ / std::max(share, least_share);
    variance_ += drift * drift;
    const double reading_variance = variance_ + deviation * deviation;
    const double limit = most_deviations * std::sqrt(reading_variance);
    const double gain = variance_ / reading_variance;
    m_ += gain * std::clamp(std::log(ratio) - m_, -limit, limit);
    variance_ *= 1 - gain;
}

float ErrorScale::scale() const {
    return static_cast<float>(std::exp(m_ + variance_ / 2));
}

} // namespace afterglow
