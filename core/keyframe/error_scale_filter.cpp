// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/error_scale_filter.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr int fresh_part = 0, carried_part = 1;
/// Standard deviations: of the drift from one reading of a part to the next, and of the noise of
/// readings.
constexpr double drift_deviation = 0.45;
constexpr double fresh_noise = 0.4, carried_noise = 0.9;
constexpr double most_deviations = 1.5;

bool is_error(double error) {
    return error > 0 && std::isfinite(error);
}

} // namespace

void ErrorScaleFilter::learn_fresh(double error, double fresh) {
    if (!is_error(error) || !is_error(fresh))
        return;
    drift(fresh_part);
    learn(std::log(error / fresh) - m_[fresh_part], Eigen::Vector2d::Unit(fresh_part), fresh_noise);
}

void ErrorScaleFilter::learn_carried(double error, double fresh, double carried) {
    if (!is_error(error) || !is_error(fresh) || !(carried >= 0 && std::isfinite(carried)))
        return;
    drift(carried_part);
    const Eigen::Vector2d parts = m_.array().exp() * Eigen::Array2d(fresh, carried);
    const Eigen::Vector2d shares = parts.cwiseAbs2() / parts.squaredNorm();
    learn(std::log(error / parts.norm()), shares, carried_noise);
}

ErrorScales ErrorScaleFilter::scales() const {
    const auto mean = [&](int part) {
        return static_cast<float>(std::exp(m_[part] + covariance_(part, part) / 2));
    };
    return {.fresh = mean(fresh_part), .carried = mean(carried_part)};
}

void ErrorScaleFilter::drift(int part) {
    double &variance = covariance_(part, part);
    variance = std::min(variance + drift_deviation * drift_deviation, prior * prior);
}

void ErrorScaleFilter::learn(double surprise, const Eigen::Vector2d &gradient, double deviation) {
    const Eigen::Vector2d cross = covariance_ * gradient;
    const double variance = gradient.dot(cross) + deviation * deviation;
    const double limit = most_deviations * std::sqrt(variance);
    m_ += cross / variance * std::clamp(surprise, -limit, limit);
    covariance_ -= cross * cross.transpose() / variance;
}

} // namespace afterglow
