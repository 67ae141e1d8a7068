// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace afterglow {

/// Learns from measurements by which factor the model of the expected error is wrong.
///
/// Each measurement of the TOF camera arrives beside the map that was estimated for the same image,
/// and so tells the true error of that map, which expected_error.hpp had predicted. With r_k the
/// ratio of the true to the modelled error at measurement k:
///
///     ln r_k = m_k + noise,   m_k = m_(k-1) + drift
///
/// m is the state of a scalar Kalman filter that starts at 0 with a wide prior. The drift makes old
/// readings count less and bounds from below how certain m can become. Real-time safe; one thread.
class ErrorScale {
public:
    /// `true_error`, `modelled_error`: mean relative errors over the same pixels, in the same unit,
    /// the latter without scale(). A pair that is not positive and finite is left out. One reading
    /// moves m as if it were off by 2.5 of its standard deviations at most.
    void learn(double true_error, double modelled_error);

    /// The factor: the mean of r at the next measurement, which is larger while m is not certain.
    float scale() const;

private:
    double m_ = 0;
    double variance_ = 0.6 * 0.6; ///< of m
};

} // namespace afterglow
