// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/camera_model.hpp"

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

} // namespace afterglow
