// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace afterglow {

/// The pixel at which `camera` sees the point X in front of it, in the picture or not. Nothing
/// where its lens shows another point there: polynomials turn back far off the axis.
inline std::optional<Eigen::Vector2d> pixel_seen(const CameraModel &camera,
                                                 const Eigen::Vector3d &X) {
    if (!(X.z() > 0))
        return std::nullopt;
    const Eigen::Vector2d at = camera.project(X);
    if (camera.lens == Lens::pinhole)
        return at;
    const auto ray = camera.ray(at.x(), at.y());
    const Eigen::Vector2d expected = X.head<2>() / X.z();
    if (!ray || (*ray - expected).norm() > 1e-3 * (1 + expected.norm()))
        return std::nullopt;
    return at;
}

/// Where between four pixels of a picture something lies, for linear interpolation.
struct Tap {
    static constexpr int one = 64; ///< parts of a pixel

    std::int32_t offset = -1; ///< of the upper left of the four; negative: outside
    std::uint8_t right = 0, down = 0;
};

/// `at`: inside a picture of width x height pixels without gaps between its rows.
inline Tap tap_at(const Eigen::Vector2d &at, int width, int height) {
    const int x = static_cast<int>(std::lround(at.x() * Tap::one));
    const int y = static_cast<int>(std::lround(at.y() * Tap::one));
    // The last pixel has no neighbour: it is the neighbour of the one before.
    const int u = std::min(x / Tap::one, width - 2), v = std::min(y / Tap::one, height - 2);
    return {v * width + u, static_cast<std::uint8_t>(x - u * Tap::one),
            static_cast<std::uint8_t>(y - v * Tap::one)};
}

} // namespace afterglow
