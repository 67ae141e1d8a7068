// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace afterglow {

/// Positive factors that are learnt from readings. Their logarithms are the state of a Kalman
/// filter, which starts at 0 with a wide prior and never becomes less certain than it was then.
/// Real-time safe; one thread.
template <int count>
class LogFactors {
public:
    using Vector = Eigen::Matrix<double, count, 1>;

    /// `prior`: standard deviation of each logarithm at first.
    explicit LogFactors(double prior)
        : prior_(prior), covariance_(prior * prior * Covariance::Identity()) {}

    const Vector &logarithms() const { return m_; }
    /// The mean of a factor, which is larger while it is not certain.
    double mean(int factor) const { return std::exp(m_[factor] + covariance_(factor, factor) / 2); }

    /// Old readings count less: the logarithm of a factor may have changed by `deviation` since.
    void drift(int factor, double deviation) {
        double &variance = covariance_(factor, factor);
        variance = std::min(variance + deviation * deviation, prior_ * prior_);
    }
    /// `surprise`: a reading, less what it was expected to be; `gradient`: of the expectation by
    /// the logarithms; `deviation`: of the reading's noise. The reading moves the state as if it
    /// were off by 1.5 of its standard deviations at most.
    void learn(double surprise, const Vector &gradient, double deviation) {
        constexpr double most_deviations = 1.5;
        const Vector cross = covariance_ * gradient;
        const double variance = gradient.dot(cross) + deviation * deviation;
        const double limit = most_deviations * std::sqrt(variance);
        m_ += cross / variance * std::clamp(surprise, -limit, limit);
        covariance_ -= cross * cross.transpose() / variance;
    }

private:
    using Covariance = Eigen::Matrix<double, count, count>;

    double prior_;
    Vector m_ = Vector::Zero();
    Covariance covariance_;
};

} // namespace afterglow
