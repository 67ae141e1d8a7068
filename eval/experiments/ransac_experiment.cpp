// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/ransac_experiment.hpp"

#include "core/paper/pose_solver.hpp"
#include "core/paper/ransac.hpp"

#include <cmath>
#include <random>

namespace afterglow {
namespace {

constexpr Intrinsics camera{525, 525, 319.5, 239.5, 640, 480};
constexpr int points = 144;
constexpr double corrupted = 0.2; ///< share

class Simulation {
public:
    explicit Simulation(RansacScore what) : what_(what) {}

    RansacScore run(int trials) {
        int solved = 0;
        for (int i = 0; i < trials; ++i) {
            const Pose truth{rotation(normal_vector(0.01)), normal_vector(0.02)};
            const std::vector<Match> matches = see(truth);
            const auto plain = solve_pose(matches, camera, 3);
            const auto robust = RansacPose({}, matches.size()).solve(matches, camera);
            if (!plain || !robust)
                continue;
            ++solved;
            what_.plain_rmse_m += (plain->T - truth.T).squaredNorm();
            what_.ransac_rmse_m += (robust->pose.T - truth.T).squaredNorm();
        }
        what_.plain_rmse_m = std::sqrt(what_.plain_rmse_m / solved);
        what_.ransac_rmse_m = std::sqrt(what_.ransac_rmse_m / solved);
        return what_;
    }

private:
    double uniform(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    Eigen::Vector3d normal_vector(double sigma) {
        const double x = normal_(random_);
        const double y = normal_(random_);
        return Eigen::Vector3d(x, y, normal_(random_)) * sigma;
    }
    std::vector<Match> see(const Pose &motion) {
        std::vector<Match> matches;
        for (int i = 0; i < points; ++i) {
            Match match{.from = {}, .to = {}, .z = uniform(1, 4)};
            match.from.x() = uniform(0, camera.width - 1);
            match.from.y() = uniform(0, camera.height - 1);
            const Eigen::Vector3d X = camera.back_project(match.from.x(), match.from.y(), match.z);
            match.to = camera.project(motion * X);
            match.to = (match.to - match.from).array().round().matrix() + match.from;
            if (what_.depth && uniform(0, 1) < corrupted)
                match.z *= uniform(0.5, 1.5);
            if (what_.flow && uniform(0, 1) < corrupted) {
                match.to.x() += uniform(-15, 15);
                match.to.y() += uniform(-15, 15);
            }
            matches.push_back(match);
        }
        return matches;
    }

    RansacScore what_;
    std::mt19937 random_{7};
    std::normal_distribution<double> normal_;
};

} // namespace

std::vector<RansacScore> simulate_ransac(int trials) {
    std::vector<RansacScore> scores;
    for (const auto &[depth, flow] : {std::pair(true, false), {false, true}, {true, true}})
        scores.push_back(Simulation({.depth = depth, .flow = flow}).run(trials));
    return scores;
}

} // namespace afterglow
