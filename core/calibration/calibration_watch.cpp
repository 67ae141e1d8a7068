// SPDX-License-Identifier: Apache-2.0
#include "core/calibration/calibration_watch.hpp"

#include "core/base/degrees.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

using namespace rig_error;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr std::size_t remembered_views = 10; ///< measurements that are remembered
constexpr int edges = 400;                   ///< of each, at most
constexpr int least_edges = 50;
constexpr double longest_focal = 300; ///< pixels, of the level: its profiles reach 2.5 degrees
constexpr std::size_t least_views = 3;
constexpr int verdicts = 2; ///< that must agree before the state changes

/// One sigma of a wrong calibration, and of a right one.
RigError sigma_of(double turned, double moved, double focal_share, double lag_s) {
    RigError sigma;
    sigma << RigError::Constant(turned).head<3>(), RigError::Constant(moved).head<3>(), focal_share,
        lag_s, 0.5;
    return sigma;
}
const RigError wrong = sigma_of(2 * radians_per_degree, 0.010, 0.03, 0.03);
const RigError right = sigma_of(0.05 * radians_per_degree, 0.001, 0.0015, 0.003);
/// Log of the odds, before looking, that one part is wrong.
const double log_odds = std::log(0.05);
/// A fit far from the calibration must be so much more like edges than the best one near it, and
/// by so many deviations of the tiles' differences.
constexpr double least_improvement = 1.25;
constexpr double least_gain = 1;
/// Noise scores less than 0.15, whatever the error; edges of real surfaces more than 0.27.
constexpr double least_score = 0.2;
/// Score that one sigma of a wrong calibration costs.
constexpr double prior_cost = 0.02;
/// Once there are enough views, one of so many measurements looks far away.
constexpr std::size_t searched_interval = 4;

struct Range {
    int first, count;
};
constexpr std::array<Range, calibration_parts> part_ranges = {
    {{turn, 3}, {displacement, 3}, {focal, 1}, {lag, 1}}};

const std::array<EdgeKernel, 4> kernels = {EdgeKernel(3), EdgeKernel(1.7), EdgeKernel(1),
                                           EdgeKernel(0.6)};

int level_for(const Intrinsics &camera, int levels) {
    int level = 1;
    while (level < levels && camera.fx / (1 << level) > longest_focal)
        ++level;
    return level;
}

/// H x = g, the unknowns in units of `wrong`.
struct Normal {
    explicit Normal(const EdgeEvidence &e)
        : H(Eigen::Matrix<float, 9, 9>(e.H.selfadjointView<Eigen::Lower>()).cast<double>()),
          g(e.g.rowwise().sum().cast<double>().cwiseProduct(wrong)) {
        H = wrong.asDiagonal() * H * wrong.asDiagonal();
    }
    Matrix9 H;
    RigError g;
};

/// What is assumed of the dispersion before looking, and as how many tiles it counts.
constexpr double assumed_dispersion = 4;
constexpr double assumed_tiles = 10;

/// How much more the tiles' sums vary than their H says: the share of edges that is independent is
/// its inverse.
double dispersion(const EdgeEvidence &evidence, const Normal &normal) {
    const Eigen::LDLT<Matrix9> inverse(normal.H + Matrix9::Identity());
    double squares = 0;
    int used = 0;
    for (int t = 0; t < EdgeEvidence::tiles; ++t) {
        const RigError g = evidence.g.col(t).cast<double>().cwiseProduct(wrong);
        if (g.isZero(0))
            continue;
        squares += g.dot(inverse.solve(g));
        ++used;
    }
    // Of the tiles' squares, the fit has taken as many as there are unknowns.
    const double unknowns = inverse.solve(normal.H).trace();
    const double seen = std::max(used - unknowns, 0.0);
    const double of_tiles = squares / std::max(unknowns, 1e-3) * used / std::max(seen, 1.0);
    return (assumed_tiles * assumed_dispersion + seen * of_tiles) / (assumed_tiles + seen);
}

/// By how many deviations the image is more like edges where one error puts them than where the
/// other does: the tiles' differences tell their own spread.
double gain(const EdgeEvidence &of, const EdgeEvidence &over) {
    const auto difference = (of.score - over.score).eval();
    return difference.sum() / std::max(difference.norm(), 1e-6f);
}

/// Means of squares, radians, of `count` edges' sums of pixels.
Matrix9 of_directions(Matrix9 squares, int count, const Intrinsics &camera) {
    squares.row(margin).setZero();
    squares.col(margin).setZero();
    // Seen across edges; there is as much along them.
    return squares * (2 / (count * camera.fx * camera.fx));
}

} // namespace

Pose correction(const RigError &error) {
    Pose pose = exp((Twist() << error.segment<3>(displacement), error.segment<3>(turn)).finished());
    pose.R.topRows<2>() *= 1 + error[focal];
    pose.T.head<2>() *= 1 + error[focal];
    return pose;
}

float amount(const RigError &error, CalibrationPart part) {
    const auto [first, size] = part_ranges[static_cast<std::size_t>(part)];
    return static_cast<float>(size == 1 ? error[first] : error.segment(first, size).norm());
}

CalibrationWatch::CalibrationWatch(const Intrinsics &camera, int levels)
    : level_(level_for(camera, levels)), camera_(camera.at_level(level_)), finder_(edges),
      dispersion_(assumed_dispersion) {
    views_.reserve(remembered_views);
    for (std::size_t i = 0; i < remembered_views; ++i)
        views_.emplace_back(camera_, edges); // a copy would have no room
}

void CalibrationWatch::add(const DepthSurface &surface, const Intrinsics &surface_camera,
                           const Pose &pose, const Pyramid &image, const Twist &rate) {
    learn(finder_.find(surface, surface_camera, pose), image.level(level_), rate);
}

void CalibrationWatch::learn(std::span<const DepthEdge> found, GreyView image, const Twist &rate) {
    if (static_cast<int>(found.size()) < least_edges || !rate.allFinite())
        return;
    EdgeView &newest = views_[seen_ % remembered_views];
    newest.take(found, image, rate);
    if (newest.size() < least_edges)
        return;
    ++seen_;

    const bool searches = seen_ <= remembered_views || seen_ % searched_interval == 0;
    RigError elsewhere = RigError::Zero();
    if (searches) {
        newest.look(RigError::Zero());
        elsewhere = search(newest);
    }
    Fit best = refine(error_, kernels.size() - 1);
    if (searches) {
        if (pixels(elsewhere - best.error) > 1)
            if (const Fit fit = refine(elsewhere, 0); fit.score > best.score)
                best = fit;
        Fit near = refine(RigError::Zero(), 0);
        if (const Fit narrow = refine(RigError::Zero(), kernels.size() - 1);
            narrow.score > near.score)
            near = narrow;
        if (near.score > best.score)
            best = near;
        credible_ = pixels(best.error - near.error) < 1 ||
                    (best.score > least_improvement * near.score &&
                     gain(best.evidence, near.evidence) > least_gain);
    }
    if (!best.error.allFinite())
        return;
    error_ = best.error;
    judge(best);
}

/// By how much an error moves edges, root mean square, pixels of the level.
double CalibrationWatch::pixels(const RigError &error) const {
    return std::sqrt(error.dot(sensitivity() * error)) * camera_.fx;
}

bool CalibrationWatch::differs(const RigError &corrected) const {
    constexpr double deviations = 3;
    RigError apart = suspected_ - corrected;
    apart[lag] = 0;
    const Matrix9 squares = sensitivity();
    return apart.dot(squares * apart) >
           deviations * deviations * (suspected_.isZero(0) ? 0.0 : (squares * covariance_).trace());
}

float CalibrationWatch::shift(const RigError &corrected) const {
    if (suspected_.isZero(0))
        return 0;
    const RigError left = suspected_ - corrected;
    // The frames that follow may be of as fast a camera as the last measurements were.
    double most = 0;
    for (const Matrix9 &squares : {newest_sensitivity(), sensitivity()})
        most = std::max(most, left.dot(squares * left) + (squares * covariance_).trace());
    return static_cast<float>(std::sqrt(most));
}

void CalibrationWatch::gather(const RigError &error, std::size_t kernel, EdgeEvidence &sum) const {
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i)
        views_[i].gather(error, kernels[kernel], sum);
}

/// Weighted least squares with ever narrower kernels.
CalibrationWatch::Fit CalibrationWatch::refine(const RigError &start, std::size_t kernel) {
    Fit at;
    at.error = start;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i)
        views_[i].look(start);
    for (int again = 0; again < 2;) {
        EdgeEvidence seen;
        gather(at.error, kernel, seen);
        const Normal normal(seen);
        const Matrix9 H = normal.H / dispersion_ + Matrix9::Identity();
        at.error += wrong.cwiseProduct(
            H.ldlt().solve(normal.g / dispersion_ - at.error.cwiseQuotient(wrong)));
        if (kernel + 1 < kernels.size())
            ++kernel;
        else
            ++again;
    }
    gather(at.error, kernel, at.evidence);
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i)
        count += views_[i].size();
    at.score = at.evidence.score.sum() / static_cast<float>(count) -
               prior_cost * at.error.cwiseQuotient(wrong).squaredNorm();
    return at;
}

/// The error that fits one view best: turns, then rolls and focal lengths, and so on.
RigError CalibrationWatch::search(const EdgeView &view) const {
    constexpr double step_px = 1.5;
    constexpr int rounds = 3, widest = 7, again = 2, rolls = 4;
    const double tilt = step_px / camera_.fx;
    const double roll = 2 * step_px / camera_.width;
    RigError best = RigError::Zero();
    const auto scan = [&](int a, double step_a, int b, double step_b, int n) {
        const RigError by_a = step_a * RigError::Unit(a), by_b = step_b * RigError::Unit(b);
        const Eigen::Vector2i at = view.scan(best, by_a, by_b, n, 2);
        best += at.x() * by_a + at.y() * by_b;
    };
    for (int round = 0; round < rounds; ++round) {
        scan(turn, tilt, turn + 1, tilt, round == 0 ? widest : again);
        scan(turn + 2, roll, focal, roll, rolls);
    }
    return best;
}

/// Which of the parts are wrong is told by the evidence (marginal likelihood) of each combination:
/// wrong ones are distributed as `wrong`, the others as `right`.
void CalibrationWatch::judge(const Fit &fit) {
    const Normal normal(fit.evidence);
    dispersion_ = dispersion(fit.evidence, normal);
    const Matrix9 H = normal.H / dispersion_;
    const RigError g = (H + Matrix9::Identity()) * fit.error.cwiseQuotient(wrong);

    RigError best = RigError::Zero();
    unsigned best_parts = 0;
    double most = -1e300;
    for (unsigned parts = 0; parts < 1U << calibration_parts; ++parts) {
        RigError scale = right.cwiseQuotient(wrong);
        double log_evidence = 0;
        for (std::size_t p = 0; p < calibration_parts; ++p)
            if ((parts >> p & 1) != 0) {
                scale.segment(part_ranges[p].first, part_ranges[p].count).setOnes();
                log_evidence += log_odds;
            }
        const Matrix9 S = scale.asDiagonal();
        const Eigen::LLT<Matrix9> posterior(Matrix9::Identity() + S * H * S);
        const RigError b = S * g, x = posterior.solve(b);
        log_evidence +=
            0.5 * b.dot(x) - posterior.matrixL().toDenseMatrix().diagonal().array().log().sum();
        if (log_evidence > most) {
            most = log_evidence;
            best = wrong.cwiseProduct(S * x);
            covariance_ = wrong.asDiagonal() * (S * posterior.solve(S)) * wrong.asDiagonal();
            best_parts = parts;
        }
    }
    suspected_.setZero();
    for (std::size_t p = 0; p < calibration_parts; ++p) {
        const auto [first, size] = part_ranges[p];
        RigError part = RigError::Zero();
        part.segment(first, size) = best.segment(first, size);
        const RigError direction = part / std::max(part.norm(), 1e-12);
        const double deviation = std::sqrt(std::max(direction.dot(covariance_ * direction), 0.0));
        const bool suspect = seen_ >= least_views && credible_ && fit.score > least_score &&
                             (best_parts >> p & 1) != 0;

        CalibrationFinding &finding = state_.parts[p];
        finding.amount = amount(best, static_cast<CalibrationPart>(p));
        finding.deviation = static_cast<float>(deviation);
        against_[p] = suspect != finding.suspect ? against_[p] + 1 : 0;
        if (against_[p] == verdicts) {
            finding.suspect = suspect;
            against_[p] = 0;
        }
        if (finding.suspect)
            suspected_ += part;
    }
}

/// Squares of the derivatives of the edges' directions (radians) by the error, their mean.
CalibrationWatch::Matrix9 CalibrationWatch::sensitivity() const {
    Matrix9 squares = Matrix9::Zero();
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i) {
        squares += views_[i].sensitivity().cast<double>();
        count += views_[i].size();
    }
    return of_directions(squares, count, camera_);
}
CalibrationWatch::Matrix9 CalibrationWatch::newest_sensitivity() const {
    const EdgeView &newest = views_[(seen_ - 1) % remembered_views];
    return of_directions(newest.sensitivity().cast<double>(), newest.size(), camera_);
}

} // namespace afterglow
