// SPDX-License-Identifier: Apache-2.0
#include "tools/characterise/noise_fit.hpp"

#include "core/base/median.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace afterglow {
namespace {

/// Bins whose depths span less than this factor do not tell the terms of the curve apart.
constexpr float least_span = 1.5F;
constexpr std::size_t least_bins = 4;

using Terms = Eigen::Vector3d; // floor, linear, quadratic

double value(const Terms &terms, double z) {
    return terms[0] + z * (terms[1] + z * terms[2]);
}

/// Whether the curve is one that a sensor can have between two depths.
bool is_noise(const Terms &terms, double nearest, double farthest) {
    if (terms[2] < 0 || value(terms, nearest) <= 0 || value(terms, farthest) <= 0)
        return false;
    const double lowest = terms[2] > 0 ? -terms[1] / (2 * terms[2]) : nearest;
    return lowest <= nearest || lowest >= farthest || value(terms, lowest) > 0;
}

/// Least squares of the relative errors over the terms chosen by the bits of `chosen`.
Terms solve(std::span<const DepthBin> bins, const Eigen::VectorXd &weights, unsigned chosen) {
    const auto rows = static_cast<Eigen::Index>(bins.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, 3);
    for (Eigen::Index i = 0; i < rows; ++i) {
        const DepthBin &bin = bins[static_cast<std::size_t>(i)];
        double power = weights[i] / bin.sigma_m;
        for (unsigned term = 0; term < 3; ++term, power *= bin.z_m)
            if (chosen >> term & 1U)
                A(i, term) = power;
    }
    return A.colPivHouseholderQr().solve(weights);
}

Eigen::VectorXd relative_errors(std::span<const DepthBin> bins, const Terms &terms) {
    Eigen::VectorXd errors(static_cast<Eigen::Index>(bins.size()));
    for (Eigen::Index i = 0; i < errors.size(); ++i) {
        const DepthBin &bin = bins[static_cast<std::size_t>(i)];
        errors[i] = value(terms, bin.z_m) / bin.sigma_m - 1;
    }
    return errors;
}

/// The best curve that a sensor can have: of all three terms, or else of some of them.
Terms best_curve(std::span<const DepthBin> bins, const Eigen::VectorXd &weights) {
    const double nearest = 0.5 * bins.front().z_m;
    const double farthest = 2.0 * bins.back().z_m;
    Terms best = Terms::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (unsigned chosen = 7; chosen > 0; --chosen) {
        const Terms terms = solve(bins, weights, chosen);
        if (!is_noise(terms, nearest, farthest))
            continue;
        const double sum = weights.cwiseProduct(relative_errors(bins, terms)).squaredNorm();
        if (sum < least) {
            least = sum;
            best = terms;
        }
    }
    return best;
}

SensorNoise fit_curve(std::span<const DepthBin> bins, const SensorNoise &configured) {
    Eigen::VectorXd counts(static_cast<Eigen::Index>(bins.size()));
    for (Eigen::Index i = 0; i < counts.size(); ++i) {
        // Of many pixels, what is wrong with a bin is no longer chance.
        const double pixels = bins[static_cast<std::size_t>(i)].pixels;
        counts[i] = std::sqrt(pixels / (pixels + 100));
    }
    Eigen::VectorXd weights = counts;
    Terms terms = best_curve(bins, weights);
    for (int round = 0; round < 5; ++round) { // Huber's weights
        const Eigen::VectorXd errors = relative_errors(bins, terms).cwiseAbs();
        const float typical = median(std::vector(errors.begin(), errors.end()));
        const double limit = std::max(1.5 * 1.4826 * typical, 0.03);
        for (Eigen::Index i = 0; i < weights.size(); ++i)
            weights[i] = counts[i] * std::sqrt(std::min(1.0, limit / std::max(errors[i], 1e-9)));
        terms = best_curve(bins, weights);
    }
    return {static_cast<float>(terms[0]), static_cast<float>(terms[1]),
            static_cast<float>(terms[2]), configured.least_relative};
}

SensorNoise scale(std::span<const DepthBin> bins, const SensorNoise &configured) {
    std::vector<float> factors;
    for (const DepthBin &bin : bins)
        factors.push_back(bin.sigma_m / configured.sigma(bin.z_m));
    SensorNoise noise = configured.times(median(factors));
    noise.least_relative = configured.least_relative;
    return noise;
}

} // namespace

NoiseFit fit_noise(std::span<const DepthBin> bins, const SensorNoise &configured) {
    assert(!bins.empty());
    NoiseFit fit;
    fit.scaled = bins.size() < least_bins || bins.back().z_m < least_span * bins.front().z_m;
    fit.noise = fit.scaled ? scale(bins, configured) : fit_curve(bins, configured);
    for (const DepthBin &bin : bins) {
        const float fitted =
            fit.noise.floor_m + bin.z_m * (fit.noise.linear + bin.z_m * fit.noise.quadratic_per_m);
        fit.misfit = std::max(fit.misfit, std::abs(fitted / bin.sigma_m - 1));
    }
    return fit;
}

} // namespace afterglow
