// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace afterglow {

/// A scene point seen in two images: where it was, where it went, and its depth in the first.
struct Match {
    Eigen::Vector2d from; ///< pixels, (u_i, v_i)
    Eigen::Vector2d to;   ///< pixels, (u_j, v_j)
    double z;             ///< metres, in the first camera's frame
};

} // namespace afterglow
