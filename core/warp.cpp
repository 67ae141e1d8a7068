// SPDX-License-Identifier: Apache-2.0
#include "core/warp.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace afterglow {
namespace {

constexpr WarpedPixel nothing = 0xffffffffu;
/// Steepest slope along which a depth is moved to the pixel's centre, share of depth per pixel.
constexpr float steepest = 0.03f;

void keep_nearest(WarpedPixel &pixel, WarpedPixel value, bool alone) {
    if (alone) {
        pixel = std::min(pixel, value);
        return;
    }
    std::atomic_ref<WarpedPixel> shared(pixel);
    WarpedPixel old = shared.load(std::memory_order_relaxed);
    while (value < old && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
}

} // namespace

Warp::Warp(const Intrinsics &camera, const WarpOptions &options)
    : camera_(camera), options_(options), nearest_(camera.width, camera.height),
      filled_(camera.width, camera.height) {}

void Warp::run(const DepthSurface &surface, const Pose &pose, WorkerPool &pool,
               const Eigen::Vector3f &skew) {
    std::fill(nearest_.pixels().begin(), nearest_.pixels().end(), nothing);
    const int rows = camera_.height;
    const int n = pool.size();
    pool.run([&](int worker) {
        scatter(surface, pose, skew, rows * worker / n, rows * (worker + 1) / n, n == 1);
    });
    pool.run([&](int worker) { fill_cracks(surface, rows * worker / n, rows * (worker + 1) / n); });
}

void Warp::scatter(const DepthSurface &surface, const Pose &pose, const Eigen::Vector3f &skew,
                   int first_row, int end_row, bool alone) {
    const int w = camera_.width, h = camera_.height;
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    K(0, 0) = camera_.fx;
    K(1, 1) = camera_.fy;
    K(0, 2) = camera_.cx;
    K(1, 2) = camera_.cy;
    const Eigen::Matrix3d KR = K * pose.R, Ki = K.inverse();
    const Eigen::Vector3f b = (K * pose.T).cast<float>();
    const float nearest = surface.options().nearest_m;
    const float farthest = surface.options().farthest_m;
    const float width = static_cast<float>(w), height = static_cast<float>(h);
    for (int v = first_row; v < end_row; ++v) {
        const float *z_row = surface.z().row(v);
        const float *z_up = surface.z().row(std::max(v - 1, 0));
        const float *z_down = surface.z().row(std::min(v + 1, h - 1));
        const std::uint8_t *edge = surface.edge_distance().row(v);
        const float fv = static_cast<float>(v);
        const Eigen::Vector3d turn = skew.cast<double>() * (static_cast<double>(v) / h - 0.5);
        const Eigen::Matrix3f A = (KR * rotation(turn) * Ki).cast<float>();
        const Eigen::Vector3f ray0 = A.col(1) * fv + A.col(2);
        for (int u = 0; u < w; ++u) {
            const float z = z_row[u];
            if (z == 0.0f || edge[u] < options_.least_edge_distance_px)
                continue;
            const float fu = static_cast<float>(u);
            const float c = z * (A(2, 0) * fu + ray0[2]) + b[2];
            if (!(c > nearest && c < farthest))
                continue;
            const float inv = 1.0f / c;
            const float x = (z * (A(0, 0) * fu + ray0[0]) + b[0]) * inv + 0.5f;
            const float y = (z * (A(1, 0) * fu + ray0[1]) + b[1]) * inv + 0.5f;
            if (!(x >= 0.0f && y >= 0.0f && x < width && y < height))
                continue;
            const int iu = static_cast<int>(x), iv = static_cast<int>(y);
            float moved = c;
            if (edge[u] > 2 && u > 0 && u + 1 < w) {
                const float l = z_row[u - 1], r = z_row[u + 1], t = z_up[u], d = z_down[u];
                if (l != 0.0f && r != 0.0f && t != 0.0f && d != 0.0f) {
                    const float half = 0.5f / z;
                    const float su = std::clamp((r - l) * half, -steepest, steepest);
                    const float sv = std::clamp((d - t) * half, -steepest, steepest);
                    const float du = static_cast<float>(iu) + 0.5f - x;
                    const float dv = static_cast<float>(iv) + 0.5f - y;
                    moved += c * (su * du + sv * dv);
                }
            }
            const WarpedPixel value = (static_cast<WarpedPixel>(moved * warped_units_per_m + 0.5f)
                                       << warped_depth_shift) |
                                      edge[u];
            keep_nearest(nearest_(iu, iv), value, alone);
        }
    }
}

// A crack is an empty pixel, or one through which a far surface shows, between two pixels of one
// surface on opposite sides.
void Warp::fill_cracks(const DepthSurface &surface, int first_row, int end_row) {
    static constexpr int directions[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    const int w = camera_.width, h = camera_.height, reach = options_.crack_px;
    for (int v = first_row; v < end_row; ++v) {
        const WarpedPixel *in = nearest_.row(v);
        WarpedPixel *out = filled_.row(v);
        for (int u = 0; u < w; ++u) {
            const WarpedPixel here = in[u];
            // Most pixels sit between their like: nothing to do.
            if (here != nothing && u > 0 && u + 1 < w &&
                (in[u - 1] > here || here - in[u - 1] < (here >> 5)) &&
                (in[u + 1] > here || here - in[u + 1] < (here >> 5))) {
                out[u] = here;
                continue;
            }
            float sum = 0, pairs = 0, opposed = 0;
            int edge = 7;
            for (const auto &d : directions) {
                WarpedPixel a = nothing, b = nothing;
                int ka = 0, kb = 0;
                for (int k = 1; k <= reach && (a == nothing || b == nothing); ++k) {
                    const int ua = u - k * d[0], va = v - k * d[1];
                    const int ub = u + k * d[0], vb = v + k * d[1];
                    if (a == nothing && ua >= 0 && ua < w && va >= 0 && va < h) {
                        a = nearest_(ua, va);
                        ka = k;
                    }
                    if (b == nothing && ub >= 0 && ub < w && vb >= 0 && vb < h) {
                        b = nearest_(ub, vb);
                        kb = k;
                    }
                }
                if (a == nothing || b == nothing || ka + kb > reach + 1)
                    continue;
                const float za = warped_z(a), zb = warped_z(b);
                const float near = std::min(za, zb);
                if (std::abs(za - zb) > surface.edge_step(near))
                    continue;
                if (here != nothing &&
                    warped_z(here) < std::max(za, zb) + surface.edge_step(near)) {
                    opposed += 1;
                    continue;
                }
                const float t = static_cast<float>(ka) / static_cast<float>(ka + kb);
                sum += za + t * (zb - za);
                pairs += 1;
                edge = std::min({edge, static_cast<int>(a & warped_edge_mask),
                                 static_cast<int>(b & warped_edge_mask)});
            }
            const float needed = here == nothing ? 1.0f : 3.0f;
            if (pairs >= needed && opposed == 0)
                out[u] = (static_cast<WarpedPixel>(sum / pairs * warped_units_per_m + 0.5f)
                          << warped_depth_shift) |
                         warped_crack | static_cast<WarpedPixel>(edge);
            else
                out[u] = here == nothing ? 0 : here;
        }
    }
}

} // namespace afterglow
