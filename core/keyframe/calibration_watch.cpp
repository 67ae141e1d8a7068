// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/calibration_watch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace afterglow {
namespace {

using namespace rig_error;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

constexpr double degree = std::numbers::pi / 180;
constexpr std::size_t remembered_views = 8; ///< measurements that are remembered
constexpr int edges = 300;                  ///< of each, at most
constexpr int least_edges = 50;
constexpr double longest_focal = 300; ///< pixels, of the level: its profiles reach 2.5 degrees
/// Neighbouring edges share their errors: each counts for a part of one.
constexpr double independent_share = 0.1;
constexpr double least_spread = 0.5;
/// A kernel's mean tells less than the place of an edge does.
constexpr double kernel_factor = 2;
/// Score that one sigma of the prior costs.
constexpr double prior_cost = 0.02;

// What makes a part suspect.
constexpr double deviations = 3;
constexpr double least_shift = 0.003; ///< radians, of image directions
constexpr double least_lag = 0.02;    ///< seconds
/// The calibration as it is has at most this share of the score of the best.
constexpr double least_gain = 0.85;
/// Chance makes scores of up to 0.3.
constexpr double least_score = 0.35;
constexpr std::size_t least_views = 3;
constexpr int verdicts = 2; ///< that must agree before the state changes
/// Chi-squared that one more part must explain.
constexpr double worth_a_part = 16;

/// What is known before looking: one sigma.
RigError prior() {
    RigError sigma;
    sigma << RigError::Constant(2 * degree).head<3>(), RigError::Constant(0.010).head<3>(), 0.03,
        0.03, 0.5;
    return sigma;
}
const RigError sigma = prior();

/// What all edges of one view may have in common: one sigma, for a camera that moves at `rate`.
/// Exposure times are not told, and rows are exposed one after the other.
RigError common_error(const Twist &rate) {
    constexpr double jitter_s = 0.004;
    const double turned = 0.05 * degree + jitter_s * rate.tail<3>().norm();
    const double moved = 0.001 + jitter_s * rate.head<3>().norm();
    RigError error;
    error << turned, turned, turned, moved, moved, moved, 0.003, jitter_s, 0.2;
    return error;
}

struct Range {
    int first, count;
};
constexpr std::array<Range, calibration_parts> part_ranges = {
    {{turn, 3}, {displacement, 3}, {focal, 1}, {lag, 1}}};

int level_for(const Intrinsics &camera, int levels) {
    int level = 1;
    while (level < levels && camera.fx / (1 << level) > longest_focal)
        ++level;
    return level;
}

/// The explanation of H x = g, in sigmas, by some parts alone and the margin.
struct Explanation {
    RigError x = RigError::Zero();
    Matrix9 covariance = Matrix9::Zero();
    double chi2 = 0;
};

Explanation explain(const Matrix9 &H, const RigError &g, unsigned parts) {
    RigError used = RigError::Zero();
    used[margin] = 1;
    for (std::size_t p = 0; p < calibration_parts; ++p)
        if ((parts >> p & 1) != 0)
            used.segment(part_ranges[p].first, part_ranges[p].count).setOnes();
    // What is not used has no derivative, and keeps its prior.
    const Matrix9 D = used.asDiagonal();
    const Matrix9 A = D * H * D + Matrix9::Identity();
    const auto decomposed = A.ldlt();
    Explanation e;
    e.x = decomposed.solve(D * g);
    e.covariance = D * decomposed.solve(D);
    e.chi2 = e.x.dot(D * g);
    return e;
}

} // namespace

CalibrationWatch::CalibrationWatch(const Intrinsics &camera, int levels)
    : level_(level_for(camera, levels)), camera_(camera.at_level(level_)), finder_(edges),
      profiles_(remembered_views, EdgeProfiles(edges)) {
    views_.reserve(remembered_views);
    for (std::size_t i = 0; i < remembered_views; ++i)
        views_.emplace_back(camera_, edges); // a copy would have no room
}

void CalibrationWatch::add(const DepthSurface &surface, const Intrinsics &surface_camera,
                           const Pose &pose, const Pyramid &image, const Twist &rate) {
    const auto found = finder_.find(surface, surface_camera, pose);
    if (static_cast<int>(found.size()) < least_edges || !rate.allFinite())
        return;
    EdgeView &newest = views_[seen_++ % remembered_views];
    newest.take(found, image.level(level_), rate);

    Fit best = refine(error_);
    const RigError elsewhere = search(newest);
    if (look(elsewhere) + against(elsewhere) > best.score)
        if (const Fit fit = refine(elsewhere); fit.score > best.score)
            best = fit;
    const double as_calibrated = look(RigError::Zero());
    if (as_calibrated > best.score)
        if (const Fit fit = refine(RigError::Zero()); fit.score > best.score)
            best = fit;
    if (!best.error.allFinite() || !best.H.allFinite())
        return;
    error_ = best.error;
    judge(best, seen_ >= least_views && best.score > least_score &&
                    as_calibrated < least_gain * best.score);
}

/// Looks up all images with an error; the mean of what is there.
double CalibrationWatch::look(const RigError &error) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i) {
        views_[i].look(error, profiles_[i]);
        sum += views_[i].score(profiles_[i], RigError::Zero(), 1) * views_[i].size();
        count += views_[i].size();
    }
    return sum / count;
}

double CalibrationWatch::against(const RigError &error) const {
    return -prior_cost * error.cwiseQuotient(sigma).squaredNorm();
}

/// Weighted least squares with ever narrower kernels; the best of what was met on the way.
CalibrationWatch::Fit CalibrationWatch::refine(const RigError &start) {
    constexpr std::array<double, 5> kernels = {3, 2, 1.5, 1, 1};
    // Means of kernels move by less than what they are the means of.
    constexpr double stride = 1.3;
    Fit best, at;
    at.error = start;
    for (const double kernel : kernels) {
        at.score = look(at.error) + against(at.error);
        const EdgeEvidence seen = gather(kernel);
        at.H = gather(kernels.back()).H;
        if (at.score > best.score)
            best = at;
        const Eigen::LDLT<Matrix9> system(seen.H + Matrix9::Identity());
        at.error +=
            stride * sigma.cwiseProduct(system.solve(seen.g - at.error.cwiseQuotient(sigma)));
    }
    return best;
}

/// What the profiles that were looked up last say, in sigmas of the prior.
EdgeEvidence CalibrationWatch::gather(double kernel) const {
    EdgeEvidence sum;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i) {
        EdgeEvidence view;
        views_[i].gather(profiles_[i], kernel, view);
        if (!(view.weight > 0))
            continue;
        const double spread =
            kernel_factor * std::max(std::sqrt(view.squares / view.weight), least_spread);
        const double share = independent_share / (spread * spread);
        const Matrix9 S = sigma.asDiagonal();
        const Matrix9 H = share * S * view.H * S;
        // However many edges a view has, what they have in common stays: (H^-1 + F)^-1.
        const RigError floor = common_error(views_[i].rate()).cwiseQuotient(sigma).cwiseAbs2();
        const Eigen::PartialPivLU<Matrix9> damping(Matrix9::Identity() + H * floor.asDiagonal());
        sum.H += damping.solve(H);
        sum.g += damping.solve(share * S * view.g);
    }
    return sum;
}

/// The error that fits one view best: turns, then rolls and focal lengths, and so on.
RigError CalibrationWatch::search(const EdgeView &view) {
    constexpr double step_px = 1.5;
    constexpr int rounds = 3, widest = 7, again = 2, rolls = 4;
    EdgeProfiles &profiles = profiles_[0]; // looked up anew afterwards
    view.look(RigError::Zero(), profiles);
    const double tilt = step_px / camera_.fx;
    const double roll = 2 * step_px / camera_.width;
    RigError best = RigError::Zero();
    double most = -1e9;
    const auto scan = [&](int a, double step_a, int b, double step_b, int n) {
        const RigError base = best;
        for (int j = -n; j <= n; ++j)
            for (int i = -n; i <= n; ++i) {
                RigError at = base;
                at[a] += i * step_a;
                at[b] += j * step_b;
                const double score = view.score(profiles, at, 2) + against(at);
                if (score > most) {
                    most = score;
                    best = at;
                }
            }
    };
    for (int round = 0; round < rounds; ++round) {
        scan(turn, tilt, turn + 1, tilt, round == 0 ? widest : again);
        scan(turn + 2, roll, focal, roll, rolls);
    }
    return best;
}

/// The fewest parts that explain the fit are what is wrong.
void CalibrationWatch::judge(const Fit &fit, bool better) {
    const RigError g = (fit.H + Matrix9::Identity()) * fit.error.cwiseQuotient(sigma);
    Explanation best;
    double most = -1;
    for (unsigned parts = 0; parts < 1U << calibration_parts; ++parts) {
        const Explanation e = explain(fit.H, g, parts);
        const double worth = e.chi2 - worth_a_part * std::popcount(parts);
        if (worth > most) {
            most = worth;
            best = e;
        }
    }
    const RigError error = sigma.cwiseProduct(best.x);
    const Matrix9 covariance = sigma.asDiagonal() * best.covariance * sigma.asDiagonal();
    const Matrix9 squares = sensitivity();
    const auto shift_by = [&](const RigError &e) { return std::sqrt(e.dot(squares * e)); };

    RigError suspected = RigError::Zero();
    for (std::size_t p = 0; p < calibration_parts; ++p) {
        const auto [first, size] = part_ranges[p];
        RigError part = RigError::Zero();
        part.segment(first, size) = error.segment(first, size);
        const double amount = part.norm();
        const RigError direction = part / std::max(amount, 1e-12);
        const double deviation = std::sqrt(std::max(direction.dot(covariance * direction), 0.0));
        const bool much = first == lag ? amount > least_lag : shift_by(part) > least_shift;
        const bool suspect = better && much && amount > deviations * deviation;

        CalibrationFinding &finding = state_.parts[p];
        finding.amount = static_cast<float>(size == 1 ? part[first] : amount);
        finding.deviation = static_cast<float>(deviation);
        against_[p] = suspect != finding.suspect ? against_[p] + 1 : 0;
        if (against_[p] == verdicts) {
            finding.suspect = suspect;
            against_[p] = 0;
        }
        if (finding.suspect)
            suspected += part;
    }
    correction_ =
        exp((Twist() << suspected.segment<3>(displacement), suspected.segment<3>(turn)).finished());
    focal_scale_ = 1 + suspected[focal];
    suspected[lag] = 0;
    shift_ = static_cast<float>(shift_by(suspected));
    corrected_shift_ =
        suspected.isZero(0) ? 0.0f : static_cast<float>(std::sqrt((squares * covariance).trace()));
}

/// Squares of the derivatives of the edges' directions (radians) by the error, their mean.
CalibrationWatch::Matrix9 CalibrationWatch::sensitivity() const {
    Matrix9 squares = Matrix9::Zero();
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, remembered_views); ++i) {
        views_[i].add_sensitivity(squares);
        count += views_[i].size();
    }
    squares.row(margin).setZero();
    squares.col(margin).setZero();
    // Seen across edges; there is as much along them.
    return squares * (2 / (count * camera_.fx * camera_.fx));
}

} // namespace afterglow
