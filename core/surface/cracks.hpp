// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <initializer_list>

namespace afterglow {

/// Widest crack of a surface that is filled, pixels.
constexpr int widest_crack_px = 2;

/// Calls visit(before, after, share) for each of the four directions in which a pixel lies between
/// two others that are there, with at most `widest` pixels (1 or 2) of a map between them: their
/// offsets in the map from the pixel, and how far it is from the first to the second, 0 to 1.
template <class There, class Visit>
void for_each_pair_across(std::ptrdiff_t stride, int widest, const There &there,
                          const Visit &visit) {
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, stride, stride + 1, 1 - stride}) {
        const bool next_before = there(-step), next_after = there(step);
        if (!next_before && !next_after)
            continue;
        const int before = next_before || widest < 2 ? 1 : 2;
        const int after = next_after || widest < 2 ? 1 : 2;
        if ((before == 1 ? next_before : there(-2 * step)) &&
            (after == 1 ? next_after : there(2 * step)))
            visit(-before * step, after * step,
                  static_cast<float>(before) / static_cast<float>(before + after));
    }
}

} // namespace afterglow
