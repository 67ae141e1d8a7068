// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/calibration_watch.hpp"

#include <Eigen/Cholesky>

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
constexpr std::size_t views = 8; ///< measurements that are remembered
constexpr int edges = 300;       ///< of each, at most
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
constexpr double least_shift = 0.0042; ///< radians, of image directions
constexpr double least_lag = 0.015;    ///< seconds
/// The calibration as it is has at most this share of the score of the best.
constexpr double least_gain = 0.8;
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

struct Range {
    int first, count;
};
constexpr std::array<Range, calibration_parts> part_ranges = {
    {{turn, 3}, {displacement, 3}, {focal, 1}, {lag, 1}}};

int level_for(const Intrinsics &camera) {
    int level = 1;
    while (camera.fx / (1 << level) > longest_focal)
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

CalibrationWatch::CalibrationWatch(const Intrinsics &camera)
    : camera_(camera.at_level(level_for(camera))), level_(level_for(camera)), finder_(edges),
      views_(views, EdgeView(camera_, edges)), profiles_(views, EdgeProfiles(edges)) {}

void CalibrationWatch::add(const DepthSurface &surface, const Intrinsics &surface_camera,
                           const Pose &pose, const Pyramid &image, const Twist &rate) {
    const auto found = finder_.find(surface, surface_camera, pose);
    if (static_cast<int>(found.size()) < least_edges || !rate.allFinite())
        return;
    EdgeView &newest = views_[seen_++ % views];
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
    judge(best, as_calibrated);
}

/// Looks up all images with an error; the mean of what is there.
double CalibrationWatch::look(const RigError &error) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, views); ++i) {
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
    const Matrix9 S = sigma.asDiagonal();
    Fit best, at;
    at.error = start;
    for (const double kernel : kernels) {
        at.score = look(at.error) + against(at.error);
        const EdgeEvidence seen = gather(kernel);
        at.H = gather(kernels.back()).H;
        if (at.score > best.score)
            best = at;
        const Eigen::LDLT<Matrix9> system(S * seen.H * S + Matrix9::Identity());
        at.error +=
            stride * sigma.cwiseProduct(system.solve(S * seen.g - at.error.cwiseQuotient(sigma)));
    }
    best.H = S * best.H * S;
    return best;
}

/// What the profiles that were looked up last say, as that many independent readings.
EdgeEvidence CalibrationWatch::gather(double kernel) const {
    EdgeEvidence evidence;
    for (std::size_t i = 0; i < std::min(seen_, views); ++i)
        views_[i].gather(profiles_[i], kernel, evidence);
    const double spread =
        kernel_factor * std::max(std::sqrt(evidence.squares / evidence.weight), least_spread);
    const double share = evidence.weight > 0 ? independent_share / (spread * spread) : 0;
    evidence.H *= share;
    evidence.g *= share;
    return evidence;
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
void CalibrationWatch::judge(const Fit &fit, double score_as_calibrated) {
    const RigError g = (fit.H + Matrix9::Identity()) * fit.error.cwiseQuotient(sigma);
    Explanation best;
    double most = -1;
    unsigned parts = 0;
    for (unsigned p = 0; p < 1U << calibration_parts; ++p) {
        const Explanation e = explain(fit.H, g, p);
        const double worth = e.chi2 - worth_a_part * std::popcount(p);
        if (worth > most) {
            most = worth;
            parts = p;
            best = e;
        }
    }
    const Matrix9 S = sigma.asDiagonal();
    const RigError error = S * best.x;
    const Matrix9 C = S * best.covariance * S;
    // Mean square shift of the edges seen, along them as well as across.
    Matrix9 squares = Matrix9::Zero();
    int count = 0;
    for (std::size_t i = 0; i < std::min(seen_, views); ++i) {
        views_[i].add_sensitivity(squares);
        count += views_[i].size();
    }
    squares *= 2 / (count * camera_.fx * camera_.fx);
    const auto shift_by = [&](const RigError &e) { return std::sqrt(e.dot(squares * e)); };

    const bool better = score_as_calibrated < least_gain * fit.score && seen_ >= least_views;
    CalibrationState verdict;
    for (std::size_t p = 0; p < calibration_parts; ++p) {
        const auto [first, size] = part_ranges[p];
        RigError part = RigError::Zero();
        part.segment(first, size) = error.segment(first, size);
        const double amount = part.norm();
        if (!(amount > 0))
            continue;
        const RigError direction = part / amount;
        const double deviation = std::sqrt(std::max(direction.dot(C * direction), 0.0));
        CalibrationFinding &finding = verdict.parts[p];
        finding.amount = static_cast<float>(size == 1 ? part[first] : amount);
        finding.deviation = static_cast<float>(deviation);
        const bool much = first == lag ? amount > least_lag : shift_by(part) > least_shift;
        finding.suspect = better && much && amount > deviations * deviation;
    }
    (void)parts;
    state_ = verdict;
    RigError moved = error;
    moved[margin] = moved[lag] = 0;
    shift_ = static_cast<float>(shift_by(moved));
    corrected_shift_ = static_cast<float>(std::sqrt((squares * C).trace()));
}

} // namespace afterglow
