// SPDX-License-Identifier: Apache-2.0
#include "core/paper/reprojection.hpp"

#include <algorithm>

namespace afterglow {
namespace {

constexpr std::uint16_t none = 0xffff;

} // namespace

ForwardReprojection::ForwardReprojection(const Intrinsics &camera, WorkerPool &pool)
    : camera_(camera), pool_(pool) {
    for (int worker = 0; worker < pool.size(); ++worker)
        nearest_.emplace_back(camera.width, camera.height);
}

void ForwardReprojection::draw_rows(DepthView from, const Pose &pose, int begin, int end,
                                    DepthMap &nearest) const {
    const Eigen::Matrix3f R = pose.R.cast<float>();
    const Eigen::Vector3f T = pose.T.cast<float>() * 1000; // millimetres
    const auto fx = static_cast<float>(camera_.fx);
    const auto fy = static_cast<float>(camera_.fy);
    const auto cx = static_cast<float>(camera_.cx);
    const auto cy = static_cast<float>(camera_.cy);
    const auto width = static_cast<float>(camera_.width);
    const auto height = static_cast<float>(camera_.height);
    const Eigen::Vector3f along_row = R.col(0) / fx; // R K^-1 (u, v, 1), from pixel to pixel
    for (int v = begin; v < end; ++v) {
        const std::uint16_t *row = from.row(v);
        const Eigen::Vector3f start =
            R * Eigen::Vector3f(-cx / fx, (static_cast<float>(v) - cy) / fy, 1);
        for (int u = 0; u < from.width(); ++u) {
            if (row[u] == 0)
                continue;
            const Eigen::Vector3f ray = start + along_row * static_cast<float>(u);
            const Eigen::Vector3f Y = ray * static_cast<float>(row[u]) + T;
            if (!(Y.z() >= 1 && Y.z() < none))
                continue;
            const float to_u = fx * Y.x() / Y.z() + cx + 0.5f;
            const float to_v = fy * Y.y() / Y.z() + cy + 0.5f;
            if (!(to_u >= 0 && to_v >= 0 && to_u < width && to_v < height))
                continue;
            std::uint16_t &pixel = nearest(static_cast<int>(to_u), static_cast<int>(to_v));
            pixel = std::min(pixel, static_cast<std::uint16_t>(Y.z() - 0.5f));
        }
    }
}

void ForwardReprojection::warp(DepthView from, const Pose &pose, ImageView<std::uint16_t> to) {
    pool_.run(pool_.size(), [&](int worker) {
        std::ranges::fill(nearest_[static_cast<std::size_t>(worker)].pixels(), none);
    });
    pool_.run_strips(camera_.height, [&](int first, int end, int worker) {
        draw_rows(from, pose, first, end, nearest_[static_cast<std::size_t>(worker)]);
    });
    pool_.run_strips(camera_.height, [&](int first, int end) {
        for (int v = first; v < end; ++v) {
            std::uint16_t *out = to.row(v);
            std::copy_n(nearest_[0].row(v), to.width(), out);
            for (std::size_t other = 1; other < nearest_.size(); ++other) {
                const std::uint16_t *row = nearest_[other].row(v);
                for (int u = 0; u < to.width(); ++u)
                    out[u] = std::min(out[u], row[u]);
            }
            for (int u = 0; u < to.width(); ++u)
                ++out[u]; // back from depth - 1; none wraps to 0
        }
    });
}

} // namespace afterglow
