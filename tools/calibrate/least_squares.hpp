// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace afterglow {

/// Residuals that depend on the same few parameters: one board in one picture, for example.
struct ResidualBlock {
    std::vector<int> parameters; ///< indices into x, those held fixed left out
    int count = 0;               ///< of residuals
    /// Writes the residuals of `x`, all parameters there are; in units of their expected noise.
    std::function<void(const Eigen::VectorXd &x, Eigen::Ref<Eigen::VectorXd> residuals)> evaluate;
};

struct LeastSquaresFit {
    Eigen::VectorXd x;
    double cost = 0; ///< mean over all residuals, 1 where the noise is as expected
    bool converged = false;
    /// Standard deviation of each parameter, from the curvature of the sum; 0 of those fixed, and
    /// infinite where the residuals do not determine it.
    Eigen::VectorXd sigma;
};

/// Minimises the sum of c^2 log(1 + (r / c)^2) over all residuals r (Cauchy's loss, c = 3: an
/// outlier of 10 sigma weighs a twelfth), by Levenberg and Marquardt's method with Jacobians from
/// central differences. Dense: for up to about a thousand parameters.
LeastSquaresFit least_squares(const Eigen::VectorXd &start,
                              const std::vector<ResidualBlock> &blocks, int most_iterations = 60);

} // namespace afterglow
