// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/alignment/alignment_template.hpp"
#include "core/alignment/residuals.hpp"
#include "core/alignment/weighted_products.hpp"
#include "core/base/rigid_motion.hpp"
#include "core/base/worker_pool.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace afterglow {

struct AlignmentOptions {
    int iterations_per_level = 8;
    /// Share of the points whose residuals are independent of each other. Texture repeats; errors
    /// of depth, lens and rolling shutter are shared by neighbours. Divides the information that
    /// the image gives, against a prior and in the covariance.
    float independent_share = 0.01f;
    /// A pose is believed when at least this share of the points in view fits it ...
    float least_inlier_share = 0.4f;
    /// ... when what is seen correlates with the keyframe by this much: of other places, with a low
    /// gain, half may fit, but they do not look alike ...
    float least_correlation = 0.8f;
    /// ... and at least this many points are in view.
    int least_points = 60;
};

/// What is known of a pose before looking: `mean`, and the information (inverse covariance) on the
/// motion (v, w) of the scene, keyframe coordinates, that is applied before it.
struct PosePrior {
    Pose mean;
    Eigen::Matrix<float, 6, 6> information = Eigen::Matrix<float, 6, 6>::Zero();
    /// One sigma of the skew, radians; 0 = both pictures were taken at one instant.
    float skew_rad = 0;
};

/// What aligning an image with a template told.
struct Alignment : Placement {
    float cost = 1e9f;      ///< mean robust cost of the points in view on a fixed scale, 0..1
    float inlier_share = 0; ///< of the points in view: residual below 2.5 expected deviations
    float correlation = 0;  ///< robust, of grey values in view with the template's
    /// Median |residual| / expected deviation, as a Gaussian's sigma; at least 1.
    float residual_scale = 1;
    int points = 0; ///< in view, finest level
    /// Covariance, the prior included, of the motion (v, w) applied to the scene in keyframe
    /// coordinates before `pose`; metres and radians.
    Eigen::Matrix<float, 6, 6> covariance = Eigen::Matrix<float, 6, 6>::Zero();
    bool good = false; ///< worth believing
};

/// Direct image alignment, inverse-compositional, coarse to fine.
///
///   minimise sum_i rho((I(pi(T X_i)) - gain K_i - offset) / s_i),   rho(r) = r^2 / (r^2 + c^2)
///
/// over the pose T, its skew (X_i is first turned by skew * row_i), gain and offset: K_i, X_i are
/// the template's grey values and points, pi the projection, s_i the deviation expected of point i,
/// rho Geman and McClure's. Each step solves one 11x11 system. Allocates when made; the calls are
/// real-time safe, and nothing is kept between them.
class DirectAlignment {
public:
    /// For templates of at most so many points a level.
    DirectAlignment(const AlignmentOptions &options, int points_per_level, WorkerPool &pool);

    /// Improves a placement over levels `coarsest` down to `finest`. False, and `at` as it was,
    /// where too few points are in view, the system cannot be solved, or a step is longer than 1 m
    /// or 0.5 rad.
    bool refine(const AlignmentTemplate &reference, const Pyramid &image, const PosePrior &prior,
                int coarsest, int finest, Placement &at);

    /// A placement at a pose, without skew. Its gain and offset give the grey values of the
    /// template's points on one level the mean and standard deviation of those that the image shows
    /// there. They are about right some pixels away from the true pose, too. Gain 1 and offset 0
    /// where template or image has no contrast.
    Placement with_brightness(const AlignmentTemplate &reference, const Pyramid &image,
                              const Pose &pose, int level);

    /// Alignment::cost at the pose and skew of `at` on one level, with the gain and offset that fit
    /// best there; 1e9 where too few points are in view.
    float cost(const AlignmentTemplate &reference, const Pyramid &image, const Placement &at,
               int level);

    /// refine() from `start`, and how good the result is. Where refine() fails it is not good and
    /// is placed as `start`. `scale`: the Alignment::residual_scale that is expected on the
    /// coarsest level; 0 = it is found there, as it is on the others.
    Alignment align(const AlignmentTemplate &reference, const Pyramid &image,
                    const Placement &start, const PosePrior &prior, int coarsest, int finest,
                    float scale = 0);

private:
    /// Of the residuals of some points.
    struct Part {
        WeightedProducts
            products; ///< of the unknowns' derivatives, at a gain of 1, and of the error
        using Histogram = std::array<int, Residuals::bins + 1>;
        Histogram histogram;

        void clear();
        void count(std::span<const std::int32_t> bins);
        void add(const Part &other);
    };
    struct Sums;
    struct Fit;
    /// Which products sum_up() finds: none, those of gain and offset, those with the error, or all.
    enum class Wanted { scale, brightness, error, all };
    /// `fit`: of the last level; its scale beforehand is that expected on the coarsest one.
    bool refine(const AlignmentTemplate &reference, const Pyramid &image, const PosePrior &prior,
                int coarsest, int finest, Placement &at, Fit &fit);
    /// How good a placement is that has been looked up last; `fit` is of the steps that led to it.
    Alignment assess(const AlignmentTemplate &reference, int level, const PosePrior &prior,
                     const Placement &placed, const Fit &fit);
    /// Sums over the residuals of a level at a placement. What `image` shows at its points is
    /// looked up first; null: it was, at this pose and skew. `scale`: the residuals' assumed
    /// deviation, in expected deviations; the robust cost's width is a multiple of it.
    void sum_up(const AlignmentTemplate &reference, const Pyramid *image, int level,
                const Placement &at, float scale, Wanted wanted, Sums &sums);
    void sum_up_part(const TemplatePoints &points, int first, int end, const Placement &at,
                     float cost_width, Wanted wanted, Part &part) const;

    AlignmentOptions options_;
    WorkerPool &pool_;
    std::vector<Part> parts_;   ///< of the points of a level
    AlignedVector<float> grey_; ///< PointsSeen::grey of all points of a level
};

} // namespace afterglow
