// SPDX-License-Identifier: Apache-2.0
#include "eval/datasets/lens.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afterglow {

Eigen::Vector2d LensDistortion::distort(const Eigen::Vector2d &x) const {
    const double r2 = x.squaredNorm();
    const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double xy = 2 * x.x() * x.y();
    return {x.x() * radial + p1 * xy + p2 * (r2 + 2 * x.x() * x.x()),
            x.y() * radial + p2 * xy + p1 * (r2 + 2 * x.y() * x.y())};
}

Eigen::Vector2d LensDistortion::undistort(const Eigen::Vector2d &x) const {
    Eigen::Vector2d guess = x;
    for (int i = 0; i < 50; ++i) {
        const Eigen::Vector2d miss = x - distort(guess);
        guess += miss;
        if (miss.squaredNorm() < 1e-20)
            break;
    }
    return guess;
}

Luma undistorted(LumaView image, const Intrinsics &camera, const LensDistortion &lens) {
    assert(image.width() == camera.width && image.height() == camera.height);
    Luma out(camera.width, camera.height);
    for (int v = 0; v < out.height(); ++v) {
        for (int u = 0; u < out.width(); ++u) {
            const Eigen::Vector2d seen =
                lens.distort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
            const double x = std::clamp(camera.fx * seen.x() + camera.cx, 0.0, out.width() - 1.0);
            const double y = std::clamp(camera.fy * seen.y() + camera.cy, 0.0, out.height() - 1.0);
            const int left = static_cast<int>(x), right = std::min(left + 1, out.width() - 1);
            const int top = static_cast<int>(y), bottom = std::min(top + 1, out.height() - 1);
            const double upper = std::lerp(image(left, top), image(right, top), x - left);
            const double lower = std::lerp(image(left, bottom), image(right, bottom), x - left);
            out(u, v) = static_cast<std::uint8_t>(std::lerp(upper, lower, y - top) + 0.5);
        }
    }
    return out;
}

} // namespace afterglow
