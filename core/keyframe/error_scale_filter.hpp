// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/keyframe/expected_error.hpp"

#include <Eigen/Core>

namespace afterglow {

/// Learns from measurements by which factors the two parts of a modelled error are wrong: f, that
/// of a map just measured, and g, that of what carrying the map adds in quadrature.
///
/// With e_0 and c the two parts as modelled, each measurement brings up to two readings: R, the
/// mean relative difference of the measured map and an earlier one, and t, the true error of the
/// map that was estimated for the same image:
///
///     ln R = ln(f e_0) + noise
///     ln t = ln hypot(f e_0, g c) + noise
///
/// (ln f, ln g) is the state of an extended Kalman filter, which starts at 0 with a wide prior. It
/// drifts from reading to reading, so that old readings count less; it never becomes less certain
/// than before the first one. Real-time safe; one thread.
class ErrorScaleFilter {
public:
    /// All errors in one unit, those modelled without scales(). A reading with an error that is not
    /// positive and finite is left out. One reading moves the state as if it were off by 1.5 of its
    /// standard deviations at most.

    /// R = `error`, e_0 = `fresh`.
    void learn_fresh(double error, double fresh);
    /// t = `error`, e_0 = `fresh`, c = `carried`, which may be 0.
    void learn_carried(double error, double fresh, double carried);

    /// The means of f and g, which are larger while they are not certain.
    ErrorScales scales() const;

private:
    void drift(int part);
    /// `surprise`: of a reading, less its expectation; `gradient`: of the expectation;
    /// `deviation`: of the noise.
    void learn(double surprise, const Eigen::Vector2d &gradient, double deviation);

    static constexpr double prior = 0.8; ///< standard deviation
    Eigen::Vector2d m_ = Eigen::Vector2d::Zero();
    Eigen::Matrix2d covariance_ = prior * prior * Eigen::Matrix2d::Identity();
};

} // namespace afterglow
