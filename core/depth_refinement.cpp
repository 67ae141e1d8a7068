// SPDX-License-Identifier: Apache-2.0
#include "core/depth_refinement.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace afterglow {
namespace {

using Vector6 = Eigen::Matrix<float, 6, 1>;
using Matrix6 = Eigen::Matrix<float, 6, 6>;

constexpr int bins = 64;
constexpr float bin_width = 0.25f;

struct Sums {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    std::array<int, bins> histogram{};
    int sampled = 0, compared = 0, inliers = 0;

    float scale() const {
        int left = compared / 2;
        for (std::size_t i = 0; i < bins; ++i) {
            if (left < histogram[i])
                return 1.4826f * bin_width * (static_cast<float>(i) + 0.5f);
            left -= histogram[i];
        }
        return 1.4826f * bin_width * bins;
    }
};

// The motion is applied after the pose, in the current camera's frame: X' -> X' + v + w x X'.
void accumulate(const DepthSurface &from, const DepthSurface &to, const Intrinsics &c,
                const Pose &pose, int grid, float scale, Sums &sums) {
    const Eigen::Matrix3f R = pose.R.cast<float>();
    const Eigen::Vector3f T = pose.T.cast<float>();
    const float fx = static_cast<float>(c.fx), fy = static_cast<float>(c.fy);
    const float cx = static_cast<float>(c.cx), cy = static_cast<float>(c.cy);
    const int w = c.width, h = c.height;
    const float width2 = 6.25f * scale * scale;
    for (int v = grid; v < h - grid; v += grid)
        for (int u = grid; u < w - grid; u += grid) {
            const float z = from.z()(u, v);
            if (z == 0.0f || from.edge_distance()(u, v) < 4)
                continue;
            ++sums.sampled;
            const Eigen::Vector3f X{(static_cast<float>(u) - cx) / fx * z,
                                    (static_cast<float>(v) - cy) / fy * z, z};
            const Eigen::Vector3f Y = R * X + T;
            if (!(Y.z() > 0.1f))
                continue;
            const float inv = 1.0f / Y.z();
            const float pu = fx * Y.x() * inv + cx, pv = fy * Y.y() * inv + cy;
            if (!(pu >= 3.0f && pv >= 3.0f && pu < static_cast<float>(w - 4) &&
                  pv < static_cast<float>(h - 4)))
                continue;
            const int iu = static_cast<int>(pu + 0.5f), iv = static_cast<int>(pv + 0.5f);
            if (to.edge_distance()(iu, iv) < 4)
                continue;
            const float d = to.z()(iu, iv);
            const float l = to.z()(iu - 3, iv), r = to.z()(iu + 3, iv);
            const float t = to.z()(iu, iv - 3), b = to.z()(iu, iv + 3);
            if (d == 0.0f || l == 0.0f || r == 0.0f || t == 0.0f || b == 0.0f)
                continue;
            const float du = (r - l) * (1.0f / 6.0f), dv = (b - t) * (1.0f / 6.0f);
            const float e =
                d + du * (pu - static_cast<float>(iu)) + dv * (pv - static_cast<float>(iv)) - Y.z();
            const float sigma = to.options().noise.sigma(d);
            const float n = std::abs(e) / sigma;
            ++sums.compared;
            sums.inliers += n < 4.0f;
            ++sums.histogram[static_cast<std::size_t>(
                std::min(static_cast<int>(std::min(n, 1000.0f) / bin_width), bins - 1))];
            const float robust = width2 / (n * n + width2);
            const float weight = robust * robust / (sigma * sigma);
            // d(e)/d(v, w): the sampled depth changes as the point moves across the map.
            const float a = du * fx * inv, q = dv * fy * inv;
            const Eigen::Vector3f dY{a, q, -(a * Y.x() + q * Y.y()) * inv - 1.0f};
            Vector6 J;
            J.head<3>() = dY;
            J.tail<3>() = Y.cross(dY);
            sums.H.noalias() += weight * J * J.transpose();
            sums.g.noalias() -= weight * e * J;
        }
}

} // namespace

DepthFit refine_by_depth(const DepthSurface &from, const DepthSurface &to, const Intrinsics &camera,
                         const Pose &start, const Matrix6 &start_information,
                         const DepthRefinementOptions &options) {
    DepthFit fit;
    fit.pose = start;
    Pose pose = start;
    float scale = 8.0f;
    for (int i = 0; i <= options.iterations; ++i) {
        Sums sums;
        accumulate(from, to, camera, pose, options.grid_px, scale, sums);
        if (sums.compared < 100)
            return fit;
        scale = std::clamp(sums.scale(), 1.0f, 16.0f);
        fit.pose = pose;
        fit.residual_scale = scale;
        fit.inlier_share = static_cast<float>(sums.inliers) / static_cast<float>(sums.compared);
        fit.compared_share = static_cast<float>(sums.compared) / static_cast<float>(sums.sampled);
        if (i == options.iterations)
            break;
        // Neighbouring readings share their errors: each counts for a part of one.
        Matrix6 H = 0.05f * sums.H + start_information;
        Vector6 off; // how far the pose has been moved from the start
        const Pose moved = pose * start.inverse();
        const Eigen::AngleAxisd turn(moved.R);
        off << moved.T.cast<float>(), (turn.axis() * turn.angle()).cast<float>();
        const Vector6 g = 0.05f * sums.g - start_information * off;
        H.diagonal() += 1e-5f * H.diagonal() + Vector6::Constant(1e-3f);
        const Vector6 x = H.ldlt().solve(g);
        if (!x.allFinite() || x.tail<3>().norm() > 0.3f || x.head<3>().norm() > 0.5f)
            return fit;
        pose = Pose{rotation(x.tail<3>().cast<double>()), x.head<3>().cast<double>()} * pose;
        if (x.norm() < 1e-5f)
            i = std::max(i, options.iterations - 1);
    }
    fit.good = fit.inlier_share >= options.least_inlier_share;
    return fit;
}

} // namespace afterglow
