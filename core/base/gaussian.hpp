// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Constants of a Gaussian of unit deviation.
namespace afterglow::gaussian {

inline constexpr float mean_absolute = 0.7979f;   ///< mean of |x|: sqrt(2 / pi)
inline constexpr float median_absolute = 0.6745f; ///< median of |x|
/// The deviation over the median of |x|, as robust statistics use it.
inline constexpr float deviation_of_median = 1.4826f;

} // namespace afterglow::gaussian
