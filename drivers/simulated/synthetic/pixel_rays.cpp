// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/pixel_rays.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace afterglow {

PixelRays::PixelRays(const CameraModel &camera)
    : x_(camera.pinhole.width, camera.pinhole.height, std::numeric_limits<float>::quiet_NaN()),
      y_(x_), level_(width(), height()) {
    for (int v = 0; v < height(); ++v) {
        for (int u = 0; u < width(); ++u) {
            if (const auto ray = camera.ray(u, v)) {
                x_.row(v)[u] = static_cast<float>(ray->x());
                y_.row(v)[u] = static_cast<float>(ray->y());
            }
        }
    }
    const double smallest = 1e-6;
    for (int v = 0; v < height(); ++v) {
        for (int u = 0; u < width(); ++u) {
            const Eigen::Matrix2d step = per_pixel(u, v);
            const double side = std::max({step.col(0).norm(), step.col(1).norm(), smallest});
            level_.row(v)[u] = static_cast<float>(std::log2(side));
        }
    }
}

Eigen::Matrix2d PixelRays::per_pixel(int u, int v) const {
    const auto slope = [&](int du, int dv) -> Eigen::Vector2d {
        int pixels = 0;
        Eigen::Vector2d ends[2];
        for (const int sign : {-1, 1}) {
            const int x = std::clamp(u + sign * du, 0, width() - 1);
            const int y = std::clamp(v + sign * dv, 0, height() - 1);
            const bool moved = (x != u || y != v) && is_seen(x, y);
            ends[sign > 0] = moved ? at(x, y) : at(u, v);
            pixels += moved;
        }
        return pixels > 0 ? Eigen::Vector2d((ends[1] - ends[0]) / pixels) : Eigen::Vector2d::Zero();
    };
    Eigen::Matrix2d step;
    step << slope(1, 0), slope(0, 1);
    return step;
}

Places PixelRays::places(int u, int v, int count) const {
    const auto n = static_cast<std::size_t>(count);
    return {{x_.row(v) + u, n}, {y_.row(v) + u, n}, {level_.row(v) + u, n}};
}

} // namespace afterglow
