// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/direct_alignment.hpp"

#include "core/base/gaussian.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <utility>

namespace afterglow {
namespace {

constexpr int unknowns = TemplatePoints::derivatives + 1; // v, w, skew, gain, offset
constexpr int at_skew = TemplatePoints::by_skew, at_gain = TemplatePoints::by_gain;
constexpr int at_offset = TemplatePoints::derivatives;
constexpr float gain_unit = TemplatePoints::gain_unit, middle_grey = TemplatePoints::middle_grey;
/// The first of columns that have gain, offset and error among them; a multiple of 4.
constexpr int first_of_brightness = at_gain / 4 * 4;
using Vector = Eigen::Matrix<float, unknowns, 1>;
using Matrix = Eigen::Matrix<float, unknowns, unknowns>;

constexpr int inlier_bins = 20; // residuals below 2.5 expected deviations
static_assert(inlier_bins * Residuals::bin_width == 2.5f);
/// A level is left when a step is less than so many of the pose's standard deviations; the last one
/// later, since no other improves on it.
constexpr float coarse_step = 0.2f, last_step = 0.05f;
constexpr float lowest_gain = 0.4f, highest_gain = 2.5f;
/// Of residuals that have not been looked at: generous until they have shown their own.
constexpr float first_scale = 8.0f;
/// Geman-McClure width in units of the residuals' own scale.
constexpr float robust_width = 2.5f;

/// By which factor the Gauss-Newton steps of a level are lengthened (Aitken's method). The weights
/// change with the residuals, so that a step is followed by one in much the same direction, r times
/// as long; r < 0 if the first was too long. A step times 1 / (1 - r) is as long as the sum of all.
class Relaxation {
public:
    /// For the step x from where the gradient is g, by which x has been found.
    float factor(const Vector &x, const Vector &g) {
        constexpr float least = 0.5f, most = 1.5f;
        if (square_ > 0)
            factor_ = std::clamp(factor_ / std::max(1 - x_.dot(g) / square_, 0.1f), least, most);
        x_ = x;
        square_ = x.dot(g);
        return factor_;
    }

private:
    Vector x_ = Vector::Zero(); ///< the step before, as it was found
    float square_ = 0;          ///< its square, in units of the normal matrix
    float factor_ = 1;
};

/// Points that a worker takes at a time.
constexpr int points_at_once = std::min(Residuals::most_points, WeightedProducts::most_rows);

int parts_of(int points) {
    return (points + points_at_once - 1) / points_at_once;
}
/// The first of a part's points, and where its last block ends.
std::pair<int, int> points_of(int part, const TemplatePoints &points) {
    const int first = part * points_at_once;
    return {first, std::min(first + points_at_once, points.blocks_end())};
}

} // namespace

/// Of the residuals of a level at one placement.
struct DirectAlignment::Sums : Part {
    float gain; ///< of the placement
    int visible;

    /// Of two unknowns; `unknowns` stands for the error.
    float product(int i, int j) const {
        // What derives from the template's gradients grows with the gain.
        const double scale = (i < at_gain ? gain : 1.0f) * (j < at_gain ? gain : 1.0f);
        return static_cast<float>(scale * products(std::min(i, j), std::max(i, j)));
    }
    Matrix normal_matrix() const {
        return Matrix::NullaryExpr([this](Eigen::Index i, Eigen::Index j) {
            return product(static_cast<int>(i), static_cast<int>(j));
        });
    }
    Vector right_side() const {
        return Vector::NullaryExpr(
            [this](Eigen::Index i) { return product(static_cast<int>(i), unknowns); });
    }
    int inliers() const {
        return std::accumulate(histogram.begin(), histogram.begin() + inlier_bins, 0);
    }
    /// Mean robust cost on a fixed scale, so that baseline poses can be compared: 0 = all fit.
    float fixed_cost() const {
        constexpr float width2 = 9.0f;
        float sum = 0;
        for (std::size_t i = 0; i < Residuals::bins; ++i) {
            const float r = Residuals::bin_width * (static_cast<float>(i) + 0.5f);
            sum += static_cast<float>(histogram[i]) * r * r / (r * r + width2);
        }
        return sum / static_cast<float>(std::max(visible, 1));
    }
    /// Weighted correlation of the grey values seen with the template's, at that gain. NaN if one
    /// of them has no contrast.
    double correlation() const {
        // In the units of the unknown gain: what is seen is slope * k + error + something.
        const double slope = gain / gain_unit;
        const double n = product(at_offset, at_offset);
        const double mean_k = product(at_gain, at_offset) / n;
        const double mean_e = product(at_offset, unknowns) / n;
        const double var_k = product(at_gain, at_gain) / n - mean_k * mean_k;
        const double cov = product(at_gain, unknowns) / n - mean_k * mean_e;
        const double var_e = product(unknowns, unknowns) / n - mean_e * mean_e;
        const double var_seen = var_e + slope * (2 * cov + slope * var_k);
        return (cov + slope * var_k) / std::sqrt(var_k * var_seen);
    }
    /// Deviation by which the robust weights divide residuals: deviation(), at least 1.
    float scale() const { return std::max(deviation(), 1.0f); }
    /// Standard deviation of the residuals, in units of the expected one: from their median, as for
    /// a Gaussian; at least 0.1 and at most 12.
    float deviation() const {
        int left = visible / 2;
        float median = Residuals::bin_width * Residuals::bins;
        for (std::size_t i = 0; i < Residuals::bins; ++i) {
            if (left < histogram[i]) {
                median = Residuals::bin_width *
                         (static_cast<float>(i) +
                          static_cast<float>(left) / static_cast<float>(histogram[i]));
                break;
            }
            left -= histogram[i];
        }
        return std::clamp(gaussian::deviation_of_median * median, 0.1f, 12.0f);
    }
};

/// What steps have shown of a level's residuals.
struct DirectAlignment::Fit {
    float scale = 0;  ///< of the last step's, in expected deviations; 0 = not known
    Matrix curvature; ///< normal matrix of the first step; of later ones, which are short, too
};

void DirectAlignment::Part::clear() {
    products.clear();
    histogram.fill(0);
}

/// Adds to the histogram. Neighbouring points are often in one bin, and an increment waits until
/// the one before of the same bin is stored: so every second point is counted in a second table.
void DirectAlignment::Part::count(std::span<const std::int32_t> bins) {
    static_assert(TemplatePoints::block % 2 == 0);
    Histogram second{};
    for (std::size_t i = 0; i < bins.size(); i += 2) {
        ++histogram[static_cast<std::size_t>(bins[i])];
        ++second[static_cast<std::size_t>(bins[i + 1])];
    }
    std::ranges::transform(histogram, second, histogram.begin(), std::plus<>());
}

void DirectAlignment::Part::add(const Part &other) {
    products.add(other.products);
    std::ranges::transform(histogram, other.histogram, histogram.begin(), std::plus<>());
}

DirectAlignment::DirectAlignment(const AlignmentOptions &options, int points_per_level,
                                 WorkerPool &pool)
    : options_(options), pool_(pool), parts_(static_cast<std::size_t>(parts_of(points_per_level))),
      grey_(parts_.size() * points_at_once) {}

// The parts are the same, and added up in the same order, whoever found them.
void DirectAlignment::sum_up(const AlignmentTemplate &reference, const Pyramid *image, int level,
                             const Placement &at, float scale, Wanted wanted, Sums &sums) {
    const TemplatePoints &points = reference.points(level);
    const int count = parts_of(points.count);
    pool_.run(count, [&](int part) {
        const auto [first, end] = points_of(part, points);
        if (image != nullptr)
            find_greys(points, first, end, image->level(level), reference.camera(level), at, grey_);
        sum_up_part(points, first, end, at, robust_width * scale, wanted,
                    parts_[static_cast<std::size_t>(part)]);
    });
    sums.clear();
    for (int part = 0; part < count; ++part)
        sums.add(parts_[static_cast<std::size_t>(part)]);
    sums.gain = at.gain;
    sums.visible =
        std::accumulate(sums.histogram.begin(), sums.histogram.begin() + Residuals::bins, 0);
}

void DirectAlignment::sum_up_part(const TemplatePoints &points, int begin, int end,
                                  const Placement &at, float cost_width, Wanted wanted,
                                  Part &part) const {
    alignas(cache_line) static constexpr std::array<float, points_at_once> ones = [] {
        std::array<float, points_at_once> column{};
        column.fill(1);
        return column;
    }();
    const int count = end - begin;
    part.clear();
    Residuals residuals;
    find_residuals(points, begin, end, grey_.data() + begin, at, cost_width, residuals);
    part.count(std::span(residuals.bin).first(static_cast<std::size_t>(count)));
    if (wanted == Wanted::scale)
        return;
    std::array<const float *, unknowns + 1> columns{};
    for (int i = 0; i < TemplatePoints::derivatives; ++i)
        columns[static_cast<std::size_t>(i)] = points.J.row(i) + begin;
    columns[at_offset] = ones.data();
    columns[unknowns] = residuals.error.data();
    if (wanted == Wanted::error)
        part.products.add_with_last(columns, residuals.weight.data(), count);
    else
        part.products.add(columns, residuals.weight.data(), count,
                          wanted == Wanted::brightness ? first_of_brightness : 0);
}

bool DirectAlignment::refine(const AlignmentTemplate &reference, const Pyramid &image,
                             const PosePrior &prior, int coarsest, int finest, Placement &at) {
    Fit fit;
    return refine(reference, image, prior, coarsest, finest, at, fit);
}

bool DirectAlignment::refine(const AlignmentTemplate &reference, const Pyramid &image,
                             const PosePrior &prior, int coarsest, int finest, Placement &at,
                             Fit &fit) {
    Placement found = at;
    Sums sums;
    for (int level = coarsest; level >= finest; --level) {
        const int all = reference.points(level).count;
        const float enough = level > finest ? coarse_step : last_step;
        const bool scale_known = level == coarsest && fit.scale > 0;
        float &scale = fit.scale;
        Relaxation relaxation;
        for (int i = 0; i < options_.iterations_per_level; ++i) {
            const Pyramid *to_look_up = &image;
            if (i == 0 && !scale_known) {
                sum_up(reference, to_look_up, level, found, first_scale, Wanted::scale, sums);
                scale = sums.scale();
                to_look_up = nullptr;
            }
            sum_up(reference, to_look_up, level, found, scale, i == 0 ? Wanted::all : Wanted::error,
                   sums);
            if (sums.visible < std::min(options_.least_points, all / 2) || sums.visible < 12)
                return false; // nothing to hold on to
            if (i == 0)
                fit.curvature = sums.normal_matrix();
            else
                scale = std::clamp(sums.scale(), 0.5f * scale, 2.0f * scale);
            // Damping relative to each unknown's own curvature.
            Matrix H = fit.curvature;
            Vector g = sums.right_side();
            const float stiffness = scale * scale / options_.independent_share;
            H.topLeftCorner<6, 6>() += stiffness * prior.information;
            g.head<6>() += stiffness * prior.information *
                           log(prior.mean.inverse() * found.pose).cast<float>();
            const float skew_stiffness = stiffness / (prior.skew_rad * prior.skew_rad + 1e-10f);
            for (int k = 0; k < 3; ++k) {
                H(at_skew + k, at_skew + k) += skew_stiffness;
                g[at_skew + k] += skew_stiffness * found.skew[k];
            }
            for (int k = 0; k < unknowns; ++k)
                H(k, k) += 1e-4f * H(k, k) + 1e-6f;
            const Vector full = H.ldlt().solve(g);
            const Vector x = relaxation.factor(full, g) * full;
            if (!x.allFinite())
                return false;
            const Twist step = x.head<6>().cast<double>();
            if (step.head<3>().norm() > 1.0 || step.tail<3>().norm() > 0.5)
                return false;
            found.pose = found.pose * exp(step).inverse();
            found.skew -= x.segment<3>(at_skew);
            const float gain = found.gain + gain_unit * x[at_gain];
            found.offset += x[at_offset] - gain_unit * middle_grey * x[at_gain];
            found.gain = std::clamp(gain, lowest_gain, highest_gain);
            // The step's square in standard deviations, as assess() has them.
            if (full.dot(g) < enough * enough * stiffness)
                break;
        }
    }
    at = found;
    return true;
}

Alignment DirectAlignment::align(const AlignmentTemplate &reference, const Pyramid &image,
                                 const Placement &start, const PosePrior &prior, int coarsest,
                                 int finest, float scale) {
    Placement found = start;
    Fit fit{.scale = scale, .curvature = {}};
    if (!refine(reference, image, prior, coarsest, finest, found, fit)) {
        Alignment failed;
        static_cast<Placement &>(failed) = start;
        return failed;
    }
    return assess(reference, finest, prior, found, fit);
}

Placement DirectAlignment::with_brightness(const AlignmentTemplate &reference, const Pyramid &image,
                                           const Pose &pose, int level) {
    const TemplatePoints &points = reference.points(level);
    Placement at;
    at.pose = pose;
    find_greys(points, 0, points.blocks_end(), image.level(level), reference.camera(level), at,
               grey_);
    double n = 0, then = 0, now = 0, then2 = 0, now2 = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(points.count); ++i) {
        const double k = points.intensity[i], seen = grey_[i];
        if (seen < 0)
            continue;
        n += 1;
        then += k;
        now += seen;
        then2 += k * k;
        now2 += seen * seen;
    }
    const double var_then = n * then2 - then * then, var_now = n * now2 - now * now;
    if (!(var_then > 0 && var_now > 0))
        return at;
    at.gain =
        std::clamp(static_cast<float>(std::sqrt(var_now / var_then)), lowest_gain, highest_gain);
    at.offset = static_cast<float>((now - at.gain * then) / n);
    return at;
}

float DirectAlignment::cost(const AlignmentTemplate &reference, const Pyramid &image,
                            const Placement &at, int level) {
    Placement fitted;
    fitted.pose = at.pose;
    fitted.skew = at.skew;
    Sums sums;
    float scale = first_scale;
    for (int i = 0; i < 2; ++i) {
        sum_up(reference, i == 0 ? &image : nullptr, level, fitted, scale, Wanted::brightness,
               sums);
        scale = sums.scale();
        Eigen::Matrix2f H = sums.normal_matrix().bottomRightCorner<2, 2>();
        H(0, 0) += 1e-3f;
        H(1, 1) += 1e-3f;
        const Eigen::Vector2f x = H.ldlt().solve(sums.right_side().tail<2>());
        if (sums.visible < options_.least_points || !x.allFinite())
            return Alignment{}.cost;
        fitted.offset += x[1] - gain_unit * middle_grey * x[0];
        fitted.gain = std::clamp(fitted.gain + gain_unit * x[0], lowest_gain, highest_gain);
    }
    sum_up(reference, nullptr, level, fitted, scale, Wanted::scale, sums);
    return sums.fixed_cost();
}

Alignment DirectAlignment::assess(const AlignmentTemplate &reference, int level,
                                  const PosePrior &prior, const Placement &placed, const Fit &fit) {
    Alignment at;
    static_cast<Placement &>(at) = placed;
    Sums sums;
    sum_up(reference, nullptr, level, at, fit.scale, Wanted::brightness, sums);
    if (sums.visible < options_.least_points)
        return at;
    const float visible = static_cast<float>(sums.visible);
    const float deviation = sums.deviation();
    at.points = sums.visible;
    at.residual_scale = std::max(deviation, 1.0f);
    at.cost = sums.fixed_cost();
    at.inlier_share = static_cast<float>(sums.inliers()) / visible;
    // Causes that points share (blur, shutter, parallax) make residuals larger than expected: where
    // residuals have s of the expected deviation, the pose's deviation is s^2 instead of s times
    // that of a pose whose residuals are as expected.
    const float variance = deviation * deviation;
    Matrix H = fit.curvature * (options_.independent_share / (variance * variance));
    H.topLeftCorner<6, 6>() += prior.information;
    for (int k = 0; k < 3; ++k)
        H(at_skew + k, at_skew + k) += 1.0f / (prior.skew_rad * prior.skew_rad + 1e-10f);
    for (int k = 0; k < unknowns; ++k)
        H(k, k) += 1e-5f * H(k, k) + 1e-9f;
    const Matrix C = H.ldlt().solve(Matrix::Identity());
    at.covariance = C.topLeftCorner<6, 6>();
    at.correlation = static_cast<float>(sums.correlation());
    at.good = C.allFinite() && at.inlier_share >= options_.least_inlier_share &&
              at.correlation >= options_.least_correlation;
    return at;
}

} // namespace afterglow
