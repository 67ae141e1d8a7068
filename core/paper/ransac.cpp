// SPDX-License-Identifier: Apache-2.0
#include "core/paper/ransac.hpp"

#include "core/paper/pose_solver.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace afterglow {

RansacPose::RansacPose(const EstimatorOptions::Ransac &options, std::size_t flow_estimates)
    : options_(options), min_size_(options.min_inliers / 100 * static_cast<double>(flow_estimates)),
      random_(options.seed) {
    inliers_.reserve(flow_estimates);
    best_.reserve(flow_estimates);
}

std::size_t RansacPose::draw(std::size_t bound) {
    // SplitMix64 (Steele, Lea & Flood 2014).
    std::uint64_t x = (random_ += 0x9e3779b97f4a7c15ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    x ^= x >> 31;
    return static_cast<std::size_t>(x % bound);
}

double RansacPose::collect_inliers(std::span<const Match> matches, const Intrinsics &camera,
                                   const Pose &pose) {
    inliers_.clear();
    double sum = 0;
    for (const Match &match : matches) {
        const double r = squared_residual(match, camera, pose);
        if (r < options_.threshold) {
            inliers_.push_back(match);
            sum += r;
        }
    }
    return sum / static_cast<double>(inliers_.size());
}

std::optional<RansacPose::Solution> RansacPose::solve(std::span<const Match> matches,
                                                      const Intrinsics &camera) {
    if (matches.size() < 3)
        return std::nullopt;
    double best_mean = std::numeric_limits<double>::infinity();
    best_.clear();
    for (int i = 0; i < options_.draws; ++i) {
        const std::size_t a = draw(matches.size());
        std::size_t b = draw(matches.size() - 1);
        b += b >= a;
        std::size_t c = draw(matches.size() - 2);
        c += c >= std::min(a, b);
        c += c >= std::max(a, b);
        const std::array sample{matches[a], matches[b], matches[c]};
        const auto hypothesis = solve_pose(sample, camera, options_.hypothesis_iterations);
        if (!hypothesis)
            continue;
        const double mean = collect_inliers(matches, camera, *hypothesis);
        if (inliers_.size() >= 3 && static_cast<double>(inliers_.size()) >= min_size_ &&
            mean < best_mean) {
            best_mean = mean;
            best_.swap(inliers_);
        }
    }
    const auto pose = solve_pose(best_, camera, options_.refine_iterations);
    if (!pose)
        return std::nullopt;
    return Solution{*pose, static_cast<int>(best_.size())};
}

} // namespace afterglow
