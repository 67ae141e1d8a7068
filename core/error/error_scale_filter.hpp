// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error/expected_error.hpp"
#include "core/error/log_factors.hpp"

namespace afterglow {

/// Learns from measurements by which factors the two parts of a modelled error are wrong: f, that
/// of a map just measured, and g, that of what carrying the map adds in quadrature.
///
/// With e_0 and c the two parts as modelled, e_0 times the uncorrelated_share() of the two maps
/// that are compared, each measurement brings up to two readings: R, the mean relative difference
/// of the measured map and an earlier one, and t, the true error of the map that was estimated for
/// the same image:
///
///     ln R = ln(f e_0) + noise
///     ln t = ln hypot(f e_0, g c) + noise
///
/// (ln f, ln g) is the state of an extended Kalman filter. It drifts from reading to reading.
/// Real-time safe; one thread.
class ErrorScaleFilter {
public:
    /// All errors in one unit, those modelled without scales(). A reading with an error that is not
    /// positive and finite is left out.

    /// R = `error`, e_0 = `fresh`.
    void learn_fresh(double error, double fresh);
    /// t = `error`, e_0 = `fresh`, c = `carried`, which may be 0.
    void learn_carried(double error, double fresh, double carried);

    /// The means of f and g, which are larger while they are not certain.
    ErrorScales scales() const;

private:
    LogFactors<2> factors_{0.8};
};

} // namespace afterglow
