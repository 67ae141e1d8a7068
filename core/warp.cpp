// SPDX-License-Identifier: Apache-2.0
#include "core/warp.hpp"

#include "core/warp_kernels.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>

namespace afterglow {
namespace {

/// Points are projected so many at a time.
constexpr int strip = 128;

void keep_nearest(WarpedPixel &pixel, WarpedPixel value) {
    std::atomic_ref<WarpedPixel> shared(pixel);
    WarpedPixel old = shared.load(std::memory_order_relaxed);
    while (value < old && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
}

} // namespace

Warp::Warp(const Intrinsics &camera, const WarpOptions &options)
    : camera_(camera), options_(options),
      nearest_(camera.width + 2 * margin(), camera.height + 2 * margin()),
      filled_(camera.width, camera.height), doubtful_(camera.width, camera.height) {}

ImageView<const WarpedPixel> Warp::scattered() const {
    return {nearest_.row(margin()) + margin(), camera_.width, camera_.height, nearest_.width()};
}

void Warp::scatter(const DepthSurface &surface, const Pose &pose, WorkerPool &pool,
                   const Eigen::Vector3f &skew) {
    std::ranges::fill(nearest_.pixels(), nothing_landed);
    const int rows = camera_.height;
    const int n = pool.size();
    pool.run([&](int worker) {
        scatter_rows(surface, pose, skew, rows * worker / n, rows * (worker + 1) / n, n == 1);
    });
}

void Warp::scatter_rows(const DepthSurface &surface, const Pose &pose, const Eigen::Vector3f &skew,
                        int first_row, int end_row, bool alone) {
    const int w = camera_.width, h = camera_.height;
    const Eigen::Matrix3d K = camera_.matrix(), KR = K * pose.R, Ki = K.inverse();
    const LandingLimits limits = {surface.options().nearest_m,     surface.options().farthest_m,
                                  static_cast<float>(w),           static_cast<float>(h),
                                  options_.least_edge_distance_px, nearest_.width()};
    WarpedPixel *const to = nearest_.row(margin()) + margin();
    std::array<float, strip + 2> z;
    std::array<int, strip> offsets;
    std::array<WarpedPixel, strip> values;
    for (int v = first_row; v < end_row; ++v) {
        const Eigen::Vector3d turn = skew.cast<double>() * (static_cast<double>(v) / h - 0.5);
        const Eigen::Matrix3f A = (KR * rotation(turn) * Ki).cast<float>();
        const RowProjection row = {A.col(0), A.col(1) * static_cast<float>(v) + A.col(2),
                                   (K * pose.T).cast<float>()};
        const float *z_row = surface.z().row(v);
        const float *z_up = surface.z().row(std::max(v - 1, 0));
        const float *z_down = surface.z().row(std::min(v + 1, h - 1));
        const std::uint8_t *edge = surface.edge_distance().row(v);
        for (int u = 0; u < w; u += strip) {
            const int count = std::min(strip, w - u);
            // Beyond the picture there is no depth.
            z.front() = u > 0 ? z_row[u - 1] : 0.0f;
            std::copy_n(z_row + u, count, z.begin() + 1);
            z[static_cast<std::size_t>(count) + 1] = u + count < w ? z_row[u + count] : 0.0f;
            project_points({z.data(), z_up + u, z_down + u, edge + u, u, count}, row, limits,
                           offsets.data(), values.data());
            if (alone) {
                for (int i = 0; i < count; ++i)
                    to[offsets[i]] = std::min(to[offsets[i]], values[i]);
            } else {
                for (int i = 0; i < count; ++i)
                    keep_nearest(to[offsets[i]], values[i]);
            }
        }
    }
}

void Warp::fill_cracks(const DepthSurface &surface, DepthView taken, WorkerPool &pool) {
    const int rows = camera_.height;
    const int n = pool.size();
    pool.run([&](int worker) {
        for (int v = rows * worker / n; v < rows * (worker + 1) / n; ++v)
            fill_row(surface, taken, v);
    });
}

void Warp::fill_row(const DepthSurface &surface, DepthView taken, int v) {
    const ImageView<const WarpedPixel> landed = scattered();
    const WarpedPixel *in = landed.row(v);
    WarpedPixel *out = filled_.row(v);
    std::uint8_t *doubtful = doubtful_.row(v);
    const int w = camera_.width;
    find_doubtful({landed.row(v - 1), in, landed.row(v + 1), w}, taken.row(v), out, doubtful);
    const auto next_doubtful = [&](int from) {
        const void *at = std::memchr(doubtful + from, 1,
                                     static_cast<std::size_t>(w) - static_cast<std::size_t>(from));
        return at ? static_cast<int>(static_cast<const std::uint8_t *>(at) - doubtful) : w;
    };
    for (int u = next_doubtful(0); u < w; u = next_doubtful(u + 1))
        if (const WarpedPixel filled = fill_pixel(surface, in + u); filled != 0)
            out[u] = filled;
}

/// What the pixel at `at` of the scattered map becomes if it is a crack: an empty pixel, or one
/// through which a far surface shows, between two pixels of one surface on opposite sides; 0 if it
/// is none.
WarpedPixel Warp::fill_pixel(const DepthSurface &surface, const WarpedPixel *at) const {
    const int stride = nearest_.width(), reach = options_.crack_px;
    const bool empty = *at == nothing_landed;
    float sum = 0;
    int pairs = 0, edge = warped_edge_mask;
    for (const int step : {1, stride, stride + 1, 1 - stride}) {
        const auto next = [&](int direction) {
            int k = 1;
            while (k < reach && at[k * direction] == nothing_landed)
                ++k;
            return k;
        };
        const int before = next(-step), after = next(step);
        const WarpedPixel a = at[-before * step], b = at[after * step];
        if (a == nothing_landed || b == nothing_landed || before + after > reach + 1)
            continue;
        const float za = warped_z(a), zb = warped_z(b);
        const float limit = surface.edge_step(std::min(za, zb));
        if (std::abs(za - zb) > limit)
            continue;
        if (!empty && warped_z(*at) < std::max(za, zb) + limit)
            return 0; // it lies on the surface itself
        const float t = static_cast<float>(before) / static_cast<float>(before + after);
        sum += za + t * (zb - za);
        ++pairs;
        edge = std::min({edge, a & warped_edge_mask, b & warped_edge_mask});
    }
    if (pairs < (empty ? 1 : 3))
        return 0;
    const float z = sum / static_cast<float>(pairs);
    return (static_cast<WarpedPixel>(z * warped_units_per_m + 0.5f) << warped_depth_shift) |
           warped_crack | edge;
}

} // namespace afterglow
