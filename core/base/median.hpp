// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace afterglow {

/// The upper one of two in the middle. `values` are not empty.
template <class T>
T median(std::vector<T> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The bin of a histogram of `count` values that their median is in, the lower one of two.
inline std::size_t median_bin(std::span<const int> histogram, int count) {
    std::size_t median = 0;
    for (int below = histogram[0]; 2 * below < count; below += histogram[median])
        ++median;
    return median;
}

} // namespace afterglow
