// SPDX-License-Identifier: Apache-2.0
#include "core/paper/three_step_search.hpp"

#include <cstdlib>
#include <limits>

namespace afterglow {
namespace {

/// Sum of absolute differences of two blocks given by their top left pixels; gives up, with any
/// value not below `limit`, once it reaches `limit`.
int sum_of_absolute_differences(LumaView a, int ua, int va, LumaView b, int ub, int vb, int block,
                                int limit) {
    int sum = 0;
    for (int row = 0; row < block && sum < limit; ++row) {
        const std::uint8_t *pa = a.row(va + row) + ua;
        const std::uint8_t *pb = b.row(vb + row) + ub;
        for (int column = 0; column < block; ++column)
            sum += std::abs(pa[column] - pb[column]);
    }
    return sum;
}

} // namespace

Displacement three_step_search(LumaView from, LumaView to, int u, int v, int block, int step) {
    const int left = u - block / 2;
    const int top = v - block / 2;
    int best_cost = std::numeric_limits<int>::max();
    Displacement best;
    const auto consider = [&](int du, int dv) {
        const int l = left + du;
        const int t = top + dv;
        if (l < 0 || t < 0 || l + block > to.width() || t + block > to.height())
            return;
        const int cost = sum_of_absolute_differences(from, left, top, to, l, t, block, best_cost);
        if (cost < best_cost) {
            best_cost = cost;
            best = {du, dv};
        }
    };
    consider(0, 0);
    for (; step >= 1; step /= 2) {
        const Displacement centre = best;
        for (int dv = -step; dv <= step; dv += step)
            for (int du = -step; du <= step; du += step)
                if (du != 0 || dv != 0)
                    consider(centre.du + du, centre.dv + dv);
    }
    return best;
}

} // namespace afterglow
