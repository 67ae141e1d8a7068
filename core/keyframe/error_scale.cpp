// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// Standard deviation of ln r within a recording, measured (docs/estimation.md).
constexpr double reading_deviation = 0.45;
/// Standard deviation of the drift of m between two measurements.
constexpr double drift = 0.25;
constexpr double most_deviations = 2.5;

} // namespace

void ErrorScale::learn(double true_error, double modelled_error) {
    const double ratio = true_error / modelled_error;
    if (!(true_error > 0 && modelled_error > 0 && std::isnormal(ratio)))
        return;
    variance_ += drift * drift;
    const double reading_variance = variance_ + reading_deviation * reading_deviation;
    const double limit = most_deviations * std::sqrt(reading_variance);
    const double gain = variance_ / reading_variance;
    m_ += gain * std::clamp(std::log(ratio) - m_, -limit, limit);
    variance_ *= 1 - gain;
}

float ErrorScale::scale() const {
    return static_cast<float>(
        std::exp(m_ + (variance_ + reading_deviation * reading_deviation) / 2));
}

} // namespace afterglow
