// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/image.hpp"

#include <cstdint>

namespace afterglow {

/// How wrong an estimated depth map is (Noraky & Sze 2019, Section V-C), over the pixels where both
/// it and the truth have depth. The errors are 0 where there is no such pixel.
struct DepthErrors {
    double mre = 0;               ///< mean relative error, percent of the true depth
    double mae_cm = 0;            ///< mean absolute error
    double rmse_cm = 0;           ///< root mean squared error
    std::int64_t pixels = 0;      ///< that both have
    std::int64_t true_pixels = 0; ///< that the truth has
    /// Percent of the pixels with true depth that the estimate covers. Dropping pixels makes the
    /// errors small and this too.
    double coverage() const {
        return true_pixels > 0
                   ? 100.0 * static_cast<double>(pixels) / static_cast<double>(true_pixels)
                   : 0.0;
    }
};

/// Both maps of one size, millimetres. Real-time safe.
DepthErrors compare_depth(DepthView estimate, DepthView truth);

} // namespace afterglow
