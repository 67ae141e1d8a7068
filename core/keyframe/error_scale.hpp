// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Learns from measurements by which factor a modelled error is wrong.
///
/// With r_k the ratio of the true to the modelled error at measurement k:
///
///     ln r_k = m_k + noise,   m_k = m_(k-1) + drift
///
/// m is the state of a scalar Kalman filter that starts at 0 with a wide prior. The drift makes old
/// readings count less and bounds from below how certain m can become. Real-time safe; one thread.
class ErrorScale {
public:
    /// `reading_deviation`: standard deviation of the noise.
    explicit ErrorScale(double reading_deviation) : reading_deviation_(reading_deviation) {}

    /// `true_error`, `modelled_error`: in the same unit, the latter without scale(). A pair that is
    /// not positive and finite is left out. One reading moves m as if it were off by 2.5 of its
    /// standard deviations at most. `share`: part of the reading that is about this error; its
    /// noise grows as the inverse.
    void learn(double true_error, double modelled_error, double share = 1);

    /// The factor: the mean of exp(m), which is larger while m is not certain.
    float scale() const;

private:
    double reading_deviation_;
    double m_ = 0;
    double variance_ = 0.6 * 0.6; ///< of m
};

} // namespace afterglow
