// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/direct_alignment.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

constexpr int unknowns = 11; // v, w, skew, gain, offset
constexpr int at_skew = 6, at_gain = 9, at_offset = 10;
/// The gain is solved for about a middle grey value and in units of its own, so that its column is
/// as large as the others.
constexpr float gain_unit = 0.01f, middle_grey = 128;
using Vector = Eigen::Matrix<float, unknowns, 1>;
using Matrix = Eigen::Matrix<float, unknowns, unknowns>;
using Block = Eigen::Array<float, TemplatePoints::block, 1>;

constexpr int bins = 64;
constexpr float bin_width = 0.125f; // in expected deviations
constexpr float inlier_limit = 2.5f;
constexpr float lowest_gain = 0.4f, highest_gain = 2.5f;
/// Geman-McClure width in units of the residuals' own scale.
constexpr float robust_width = 2.5f;

} // namespace

struct DirectAlignment::Sums {
    Matrix H;
    Vector g;
    std::array<int, bins> histogram;
    float cost;
    float energy; ///< weighted sum of squared residuals, grey values
    int inliers;
    int visible;

    /// Mean robust cost on a fixed scale, so that baseline poses can be compared: 0 = all fit.
    float fixed_cost() const {
        constexpr float width2 = 9.0f;
        float sum = 0;
        for (int i = 0; i < bins; ++i) {
            const float r = bin_width * (static_cast<float>(i) + 0.5f);
            sum += static_cast<float>(histogram[static_cast<std::size_t>(i)]) * r * r /
                   (r * r + width2);
        }
        return sum / static_cast<float>(std::max(visible, 1));
    }
    /// Weighted correlation of the grey values seen with the template's, at that gain. NaN if one
    /// of them has no contrast.
    double correlation(double gain) const {
        // In the units of the unknown gain: what is seen is slope * k + error + something.
        const double slope = gain / gain_unit;
        const double n = H(at_offset, at_offset);
        const double mean_k = H(at_gain, at_offset) / n, mean_e = g[at_offset] / n;
        const double var_k = H(at_gain, at_gain) / n - mean_k * mean_k;
        const double cov = g[at_gain] / n - mean_k * mean_e;
        const double var_e = energy / n - mean_e * mean_e;
        const double var_seen = var_e + slope * (2 * cov + slope * var_k);
        return (cov + slope * var_k) / std::sqrt(var_k * var_seen);
    }
    /// Median of |residual| / expected deviation.
    float median() const {
        int left = visible / 2;
        for (int i = 0; i < bins; ++i) {
            if (left < histogram[static_cast<std::size_t>(i)])
                return bin_width * (static_cast<float>(i) +
                                    static_cast<float>(left) /
                                        static_cast<float>(histogram[static_cast<std::size_t>(i)]));
            left -= histogram[static_cast<std::size_t>(i)];
        }
        return bin_width * bins;
    }
};

void DirectAlignment::accumulate(const AlignmentTemplate &reference, ImageView<const float> image,
                                 int level, const Alignment &at, float scale, Sums &sums) const {
    sums.H.setZero();
    sums.g.setZero();
    sums.histogram.fill(0);
    sums.cost = sums.energy = 0;
    sums.inliers = sums.visible = 0;
    const TemplatePoints &points = reference.points(level);
    const float noise = reference.options().pixel_noise, noise2 = noise * noise;
    const float blur2 = options_.blur_px * options_.blur_px;
    const float width2 = robust_width * robust_width * scale * scale;
    Residuals residuals;
    Eigen::Matrix<float, TemplatePoints::block, unknowns> J, weighted;
    for (int first = 0; first < points.count; first += TemplatePoints::block) {
        find_residuals(points, first, image, reference.camera(level), at, residuals);
        const auto column = [&](const std::vector<float> &of) {
            return Eigen::Map<const Block>(of.data() + first);
        };
        const Eigen::Map<const Block> error(residuals.error.data()), seen(residuals.seen.data());
        const Block inv_s2 = 1.0f / (noise2 + blur2 * column(points.gradient).square());
        const Block r2 = error.square() * inv_s2;
        const Block r = r2.sqrt();
        for (int i = 0; i < TemplatePoints::block; ++i) {
            if (seen[i] == 0.0f)
                continue;
            const int bin = static_cast<int>(std::min(r[i], 1000.0f) / bin_width);
            ++sums.histogram[static_cast<std::size_t>(std::min(bin, bins - 1))];
            ++sums.visible;
            sums.inliers += r[i] < inlier_limit;
        }
        const Block robust = width2 / (r2 + width2);
        sums.cost += (seen * (1.0f - robust)).sum();
        const Block weight = seen * robust.square() * inv_s2;
        sums.energy += (weight * error.square()).sum();

        J.leftCols<6>() = at.gain * points.J.middleRows<TemplatePoints::block>(first);
        for (int i = 0; i < 3; ++i)
            J.col(at_skew + i).array() = J.col(3 + i).array() * column(points.row);
        J.col(at_gain).array() = gain_unit * (column(points.intensity) - middle_grey);
        J.col(at_offset).setOnes();
        weighted.array() = J.array().colwise() * weight;
        for (int i = 0; i < unknowns; ++i) {
            sums.g[i] += weighted.col(i).dot(error.matrix());
            for (int j = i; j < unknowns; ++j)
                sums.H(i, j) += weighted.col(i).dot(J.col(j));
        }
    }
    sums.H.triangularView<Eigen::StrictlyLower>() = sums.H.transpose();
}

Alignment DirectAlignment::align(const AlignmentTemplate &reference, const Pyramid &image,
                                 const Alignment &start, const PosePrior &prior, int coarsest,
                                 int finest) const {
    Alignment best;
    best.pose = start.pose;
    best.skew = start.skew;
    Alignment at = best;
    Sums sums;
    for (int level = coarsest; level >= finest; --level) {
        const int all = reference.points(level).count;
        float scale = 8.0f; // generous until the residuals have shown their own
        float previous_cost = 1e9f;
        for (int i = 0; i < options_.iterations_per_level; ++i) {
            accumulate(reference, image.level(level), level, at, scale, sums);
            if (sums.visible < std::min(options_.least_points, all / 2) || sums.visible < 12)
                return best; // not good: nothing to hold on to
            const float own = std::clamp(1.4826f * sums.median(), 1.0f, 12.0f);
            scale = i == 0 ? std::max(own, 1.0f) : std::clamp(own, 0.5f * scale, 2.0f * scale);
            if (i == 0)
                accumulate(reference, image.level(level), level, at, scale, sums);
            const float cost = sums.cost / static_cast<float>(sums.visible);
            // Damping relative to each unknown's own curvature.
            Matrix H = sums.H;
            const float stiffness = scale * scale / options_.independent_share;
            H.topLeftCorner<6, 6>() += stiffness * prior.information;
            sums.g.head<6>() +=
                stiffness * prior.information * log(prior.mean.inverse() * at.pose).cast<float>();
            const float skew_stiffness = stiffness / (prior.skew_rad * prior.skew_rad + 1e-10f);
            for (int k = 0; k < 3; ++k) {
                H(at_skew + k, at_skew + k) += skew_stiffness;
                sums.g[at_skew + k] += skew_stiffness * at.skew[k];
            }
            for (int k = 0; k < unknowns; ++k)
                H(k, k) += 1e-4f * H(k, k) + 1e-6f;
            const Vector x = H.ldlt().solve(sums.g);
            if (!x.allFinite())
                return best;
            const Twist step = x.head<6>().cast<double>();
            const double v = step.head<3>().norm(), w = step.tail<3>().norm();
            if (w > 0.5 || v > 1.0)
                return best;
            at.pose = at.pose * exp(step).inverse();
            at.skew -= x.segment<3>(at_skew);
            const float gain = at.gain + gain_unit * x[at_gain];
            at.offset += x[at_offset] - gain_unit * middle_grey * x[at_gain];
            at.gain = std::clamp(gain, lowest_gain, highest_gain);
            const double moved = reference.camera(level).fx * (w + v);
            if (moved < 0.02 || (i > 2 && std::abs(previous_cost - cost) < 1e-4f))
                break;
            previous_cost = cost;
        }
    }
    Alignment result = judge(reference, image, at, finest, prior);
    return result;
}

Alignment DirectAlignment::judge(const AlignmentTemplate &reference, const Pyramid &image,
                                 const Alignment &start, int level, const PosePrior &prior) const {
    Alignment at;
    at.pose = start.pose;
    at.skew = start.skew;
    Sums sums;
    float scale = 8.0f;
    for (int i = 0; i < 3; ++i) {
        accumulate(reference, image.level(level), level, at, scale, sums);
        if (sums.visible < options_.least_points)
            return at;
        scale = std::clamp(1.4826f * sums.median(), 1.0f, 12.0f);
        if (i == 2)
            break;
        Eigen::Matrix2f H = sums.H.bottomRightCorner<2, 2>();
        H(0, 0) += 1e-3f;
        H(1, 1) += 1e-3f;
        const Eigen::Vector2f x = H.ldlt().solve(sums.g.tail<2>());
        if (!x.allFinite())
            return at;
        at.offset += x[1] - gain_unit * middle_grey * x[0];
        at.gain = std::clamp(at.gain + gain_unit * x[0], lowest_gain, highest_gain);
    }
    const float visible = static_cast<float>(sums.visible);
    at.points = sums.visible;
    at.residual_scale = scale;
    at.cost = sums.fixed_cost();
    at.inlier_share = static_cast<float>(sums.inliers) / visible;
    at.visible_share = visible / static_cast<float>(reference.points(level).count);
    Matrix H = sums.H * (options_.independent_share / (scale * scale));
    H.topLeftCorner<6, 6>() += prior.information;
    for (int k = 0; k < 3; ++k)
        H(at_skew + k, at_skew + k) += 1.0f / (prior.skew_rad * prior.skew_rad + 1e-10f);
    for (int k = 0; k < unknowns; ++k)
        H(k, k) += 1e-5f * H(k, k) + 1e-9f;
    const Matrix C = H.ldlt().solve(Matrix::Identity());
    at.covariance = C.topLeftCorner<6, 6>();
    at.correlation = static_cast<float>(sums.correlation(at.gain));
    at.good = C.allFinite() && at.inlier_share >= options_.least_inlier_share &&
              at.correlation >= options_.least_correlation;
    return at;
}

} // namespace afterglow
