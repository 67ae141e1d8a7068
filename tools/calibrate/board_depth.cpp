// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/board_depth.hpp"

#include "core/base/median.hpp"

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

constexpr double rim = 0.1;            ///< left out of the board, where depth is mixed
constexpr int looked_at = 160;         ///< columns of a map, at least
constexpr double believed_scale = 0.5; ///< a reading further off is not the board's

/// Where the ray of a pixel meets the board: the reading that is expected, nothing beside it.
std::optional<double> expected_reading(const Board &board, const Pose &board_to_tof,
                                       const Eigen::Vector2d &ray, bool range_along_ray) {
    const Eigen::Vector3d d(ray.x(), ray.y(), 1), normal = board_to_tof.R.col(2);
    const double z = normal.dot(board_to_tof.T) / normal.dot(d);
    if (!(z > 0.01 && std::isfinite(z)))
        return std::nullopt;
    const Eigen::Vector3d place = board_to_tof.R.transpose() * (z * d - board_to_tof.T);
    const Eigen::Vector2d share = place.head<2>().cwiseQuotient(board.size_m());
    if (!(share.minCoeff() > rim && share.maxCoeff() < 1 - rim))
        return std::nullopt;
    return range_along_ray ? z * d.norm() : z;
}

} // namespace

std::vector<DepthReading> readings_on_board(const Board &board, const Pose &board_to_tof,
                                            const CameraModel &tof, bool range_along_ray,
                                            DepthView depth, double gate_m, int most) {
    std::vector<DepthReading> found;
    const int step = std::max(1, depth.width() / looked_at);
    for (int v = step / 2; v < depth.height(); v += step) {
        for (int u = step / 2; u < depth.width(); u += step) {
            const double m = depth(u, v) / 1000.0;
            const auto ray = m > 0 ? tof.ray(u, v) : std::nullopt;
            const auto expected =
                ray ? expected_reading(board, board_to_tof, *ray, range_along_ray) : std::nullopt;
            if (expected && std::abs(m - *expected) < gate_m)
                found.push_back({static_cast<double>(u), static_cast<double>(v), m});
        }
    }
    const auto every = std::max<std::size_t>(1, found.size() / static_cast<std::size_t>(most));
    std::vector<DepthReading> spread;
    for (std::size_t i = 0; i < found.size(); i += every)
        spread.push_back(found[i]);
    return spread;
}

std::optional<DepthCheck> check_depth(const Board &board, std::span<const SeenBoard> seen,
                                      const CameraModel &tof) {
    std::optional<DepthCheck> best;
    for (const bool range_along_ray : {false, true}) {
        std::vector<double> ratios, distances;
        for (const SeenBoard &each : seen) {
            const double far = each.board_to_tof.T.norm() + board.size_m().norm();
            for (const DepthReading &reading :
                 readings_on_board(board, each.board_to_tof, tof, range_along_ray, *each.depth,
                                   believed_scale * far)) {
                const double expected = *expected_reading(
                    board, each.board_to_tof, *tof.ray(reading.u, reading.v), range_along_ray);
                ratios.push_back(reading.m / expected);
                distances.push_back(expected);
            }
        }
        if (ratios.empty())
            return std::nullopt;
        std::vector<double> residuals;
        const double scale = median(ratios);
        for (std::size_t i = 0; i < ratios.size(); ++i)
            residuals.push_back((ratios[i] - scale) * distances[i]);
        const double noise = noise_of(std::move(residuals));
        if (!best || noise < best->noise_m)
            best = {range_along_ray, scale, noise};
    }
    return best;
}

} // namespace afterglow
