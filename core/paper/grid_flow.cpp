// SPDX-License-Identifier: Apache-2.0
#include "core/paper/grid_flow.hpp"

#include "core/paper/three_step_search.hpp"

namespace afterglow {

void place_grid(const EstimatorOptions::Flow &options, DepthView depth,
                std::vector<Match> &matches) {
    const int grid = options.grid;
    const int margin = options.block / 2;
    matches.clear();
    for (int j = 0; j < grid; ++j) {
        for (int i = 0; i < grid; ++i) {
            const int u = (2 * i + 1) * depth.width() / (2 * grid);
            const int v = (2 * j + 1) * depth.height() / (2 * grid);
            if (u < margin || v < margin || u + margin >= depth.width() ||
                v + margin >= depth.height() || depth(u, v) == 0)
                continue;
            const Eigen::Vector2d from(u, v);
            matches.push_back({.from = from, .to = from, .z = depth(u, v) / 1000.0});
        }
    }
}

void find_three_step_flow(const EstimatorOptions::Flow &options, LumaView previous, LumaView next,
                          std::vector<Match> &matches) {
    for (Match &match : matches) {
        const Displacement flow =
            three_step_search(previous, next, static_cast<int>(match.from.x()),
                              static_cast<int>(match.from.y()), options.block, options.step);
        match.to = match.from + Eigen::Vector2d(flow.du, flow.dv);
    }
}

} // namespace afterglow
